"""Page "Models": all models fitted to the same points, side by side."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QHeaderView, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.fields import Same
from app.services.lab.compare import ModelRow, ModelTable, compare
from widgets.common.fact_table import FactTable
from widgets.common.lab.asking import Asking
from widgets.common.lab.subject import Subject
from widgets.common.lab.tables import copy_table, fit_height
from widgets.common.numbers import UNKNOWN, show_number
from widgets.controller import Controller

LEFT, RIGHT = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight
NAME_WIDTH = 7.5
FAINT = 0.01
"""Akaike weight below which a model is as good as ruled out."""


class ModelsPage(QWidget):
    """Compares when it is looked at; a click on a row takes that model.

    Signals
    -------
    chosen(str)
        Name of a model that the user wants.
    """

    chosen = Signal(str)

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.table_shown: ModelTable | None = None
        self._subject: Subject | None = None
        self._compared: object = None
        self._asking = Asking(controller, self)
        self.words = QLabel(self)
        self.table = FactTable(
            self.tr("Models side by side"),
            (self.tr("Model"), "ΔAICc", self.tr("Weight"), "ΔBIC", self.tr("RMSE"), "k", "R²",
             "AICc", "BIC", "AIC"),
            self,
            (LEFT, *[RIGHT] * 9),
        )  # fmt: skip
        self.note = QLabel(self)
        self.copy_button = QPushButton(self.tr("&Copy table"), self)
        self._explain()
        self._lay_out()
        self.table.cellClicked.connect(self._on_cell)
        self.table.cellActivated.connect(self._on_cell)
        self.copy_button.clicked.connect(self.copy)
        self._asking.changed.connect(self._tell)
        self._asking.refused.connect(self._refuse)

    def show_subject(self, subject: Subject | None) -> None:
        """Compare models on the points of a subject, if that was not done yet."""
        self._subject = subject
        if subject is None or not subject.points.count:
            self._asking.cancel()
            self.table_shown, self._compared = None, None
            self._show_rows()
            return
        mark = (Same(subject.points.measured), subject.target.method)
        if mark != self._compared:
            self._compared = mark
            measured, method = subject.points.measured, subject.target.method
            self._asking.ask(
                self.tr("Comparing models"),
                lambda progress: compare(measured.angle, measured.value, None, method, progress),
                self._show,
            )
        else:
            self._mark_chosen()

    def forget(self) -> None:
        """Compare anew next time: the user's own models are others."""
        self._compared = None

    def copy(self) -> None:
        """Put the table on the clipboard."""
        copy_table(self.table)

    def _show(self, table: ModelTable) -> None:
        self.table_shown = table
        self._show_rows()

    def _show_rows(self) -> None:
        rows = self.table_shown.rows if self.table_shown is not None else ()
        self.table.show_rows([_write(row) for row in rows], [_tip(row) for row in rows])
        self._mark_chosen()
        fit_height(self.table, wrapped=True)
        self._tell()

    def _mark_chosen(self) -> None:
        """Bold is the best, the selected row is the model at work."""
        rows = self.table_shown.rows if self.table_shown is not None else ()
        name = "" if self._subject is None else self._subject.model.name
        for place, row in enumerate(rows):
            for column in range(self.table.columnCount()):
                item = self.table.item(place, column)
                if item is not None:
                    font = item.font()
                    font.setBold(row.best)
                    item.setFont(font)
            if row.model == name:
                self.table.selectRow(place)

    def _tell(self) -> None:
        table = self.table_shown
        self.table.setVisible(bool(table and table.rows))
        self.copy_button.setVisible(bool(table and table.rows))
        if self._asking.busy:
            self.words.setText(self.tr("Comparing…"))
        elif table is None:
            self.words.setText(self.tr("Models are compared on the points that are shown above."))
        else:
            self.words.setText(self._praise(table))
        self.note.setText(table.note if table is not None else "")
        self.note.setVisible(bool(self.note.text()))

    def _praise(self, table: ModelTable) -> str:
        best = table.best
        if best is None and any(row.result is not None for row in table.rows):
            return self.tr("No model can be called the best.")
        if best is None:
            return self.tr("No model can be fitted to these points.")
        rivals = [
            row.title for row in table.rows
            if not row.best and row.aicc_above is not None and row.aicc_above < 2.0
        ]  # fmt: skip
        if rivals:
            return self.tr("{best} describes the points best; as good: {others}.").format(
                best=best.title, others=", ".join(rivals)
            )
        return self.tr("{best} describes the points best.").format(best=best.title)

    def _refuse(self, sentence: str) -> None:
        self.table_shown = None
        self._show_rows()
        self.words.setText(sentence)

    def _on_cell(self, row: int, _: int) -> None:
        if self.table_shown is not None and self.table_shown.rows[row].result is not None:
            self.chosen.emit(self.table_shown.rows[row].model)

    def _explain(self) -> None:
        self.table.explain_columns(
            self.tr("Click a row to take that model"),
            self.tr("AICc above the least of all; below 2 there is no preference"),
            self.tr("Akaike weight: how likely this model is the best of these"),
            self.tr("BIC above the least of all; below 2 there is no preference"),
            self.tr("Root mean square of the residuals, in the unit of the channel"),
            self.tr("Fitted parameters"),
            self.tr("Share of the scatter that the curve explains"),
            self.tr("Akaike's criterion for few values: smaller is better"),
            self.tr("Bayesian criterion: smaller is better; punishes parameters more"),
            self.tr("Akaike's criterion: smaller is better"),
        )
        self.copy_button.setToolTip(self.tr("Copy the table, for a spreadsheet"))
        for label in (self.words, self.note):
            label.setWordWrap(True)
        self.note.setProperty("faint", "true")
        header = self.table.horizontalHeader()
        # Long names take two lines, so that the numbers have room beside them.
        self.table.setWordWrap(True)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
        header.resizeSection(0, round(NAME_WIDTH * self.fontMetrics().height()))
        header.setStretchLastSection(False)

    def _lay_out(self) -> None:
        buttons = QHBoxLayout()
        buttons.addWidget(self.copy_button)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (self.words, self.table, self.note):
            layout.addWidget(widget)
        layout.addLayout(buttons)
        layout.addStretch(1)
        self._tell()


def _write(row: ModelRow) -> tuple[str, ...]:
    if row.result is None:
        return (row.title, *[UNKNOWN] * 9)
    weight = UNKNOWN
    if row.weight is not None:
        weight = "< 0.01" if row.weight < FAINT else show_number(row.weight, 2)
    return (
        row.title,
        show_number(row.aicc_above, 1),
        weight,
        show_number(row.bic_above, 1),
        f"{row.rmse:.3g}",
        str(row.k),
        show_number(row.r2, 4),
        *(show_number(v, 1) for v in (row.aicc, row.bic, row.aic)),
    )


def _tip(row: ModelRow) -> str:
    return "\n".join((row.title, *row.words))
