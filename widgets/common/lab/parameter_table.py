"""Parameters of a formula model as rows: name, usual range, bounds, unit, scaling."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from app.core.errors import WrongUse
from app.core.phase.formula_model import FormulaParameter
from widgets.common.lab.tables import fit_height

NAME, FROM, TO, LOWER, UPPER, UNIT, SCALES = range(7)
START = ("0.1", "1", "", "", "1")


class ParameterTable(QTableWidget):
    """One row per name that the formula holds; what was typed stays when names come and go.

    Signals
    -------
    edited()
    """

    edited = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, 7, parent)
        self._titles: list[str] = []
        self._known: dict[str, FormulaParameter | tuple[str, ...]] = {}
        self.setAccessibleName(self.tr("Parameters of the formula"))
        for column, (title, tip) in enumerate((
            (self.tr("Name"), self.tr("As it stands in the formula")),
            (self.tr("From"), self.tr("Lower end of the usual range: searches start in it")),
            (self.tr("To"), self.tr("Upper end of the usual range")),
            (self.tr("Least"), self.tr("Lower bound of a fit; empty for none")),
            (self.tr("Most"), self.tr("Upper bound of a fit; empty for none")),
            (self.tr("Unit"), self.tr("1 for a pure number, value for the unit of the data")),
            (self.tr("Scales"), self.tr(
                "Proportional to the data: twice the intensities double it. Its range is then "
                "in units of the largest value"
            )),
        )):  # fmt: skip
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            self._titles.append(title)
            self.setHorizontalHeaderItem(column, item)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(SCALES, QHeaderView.ResizeMode.ResizeToContents)
        self.itemChanged.connect(self._on_item)

    def take(self, parameters: Sequence[FormulaParameter]) -> None:
        """Show the parameters of a model that exists."""
        self._known = {p.name: p for p in parameters}
        self.show_names([p.name for p in parameters])

    def show_names(self, names: Sequence[str]) -> None:
        """Show these parameters; those that were there before keep what was typed."""
        shown = [self._text(row, NAME) for row in range(self.rowCount())]
        if shown == list(names):
            return
        for row, name in enumerate(shown):
            self._known[name] = tuple(self._text(row, column) for column in range(FROM, SCALES)) + (
                ("yes",) if self._scales(row) else ("",)
            )
        with QSignalBlocker(self):
            self.setRowCount(len(names))
            for row, name in enumerate(names):
                self._fill(row, name)
        fit_height(self, 8)

    def read(self) -> tuple[FormulaParameter, ...]:
        """The parameters; raises `WrongUse` where something is no number."""
        return tuple(
            FormulaParameter(
                name=self._text(row, NAME),
                typical=(self._number(row, FROM), self._number(row, TO)),
                lower=self._bound(row, LOWER),
                upper=self._bound(row, UPPER),
                unit=self._text(row, UNIT) or "1",
                scales=self._scales(row),
            )
            for row in range(self.rowCount())
        )

    def _fill(self, row: int, name: str) -> None:
        known = self._known.get(name, (*START, ""))
        texts = _as_texts(known) if isinstance(known, FormulaParameter) else known
        title = QTableWidgetItem(name)
        title.setFlags(title.flags() & ~Qt.ItemFlag.ItemIsEditable)
        self.setItem(row, NAME, title)
        for column, text in zip(range(FROM, SCALES), texts, strict=False):
            self.setItem(row, column, QTableWidgetItem(text))
        tick = QTableWidgetItem()
        tick.setFlags(Qt.ItemFlag.ItemIsUserCheckable | Qt.ItemFlag.ItemIsEnabled)
        tick.setCheckState(Qt.CheckState.Checked if texts[-1] else Qt.CheckState.Unchecked)
        self.setItem(row, SCALES, tick)

    def _text(self, row: int, column: int) -> str:
        item = self.item(row, column)
        return "" if item is None else item.text().strip()

    def _scales(self, row: int) -> bool:
        item = self.item(row, SCALES)
        return item is not None and item.checkState() == Qt.CheckState.Checked

    def _bound(self, row: int, column: int) -> float | None:
        return self._number(row, column) if self._text(row, column) else None

    def _number(self, row: int, column: int) -> float:
        text = self._text(row, column)
        try:
            return float(text.replace("−", "-"))
        except ValueError:
            title = self._titles[column]
            raise WrongUse(
                self.tr("{name}, {title}: {text!r} is no number.").format(
                    name=self._text(row, NAME), title=title, text=text
                )
            ) from None

    def _on_item(self, _: QTableWidgetItem) -> None:
        self.edited.emit()


def _as_texts(p: FormulaParameter) -> tuple[str, ...]:
    bounds = ("" if bound is None else f"{bound:g}" for bound in (p.lower, p.upper))
    return (f"{p.typical[0]:g}", f"{p.typical[1]:g}", *bounds, p.unit, "yes" if p.scales else "")
