"""Page "Table": samples × channels, all fitted with the model and the way chosen above."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.core.fitting.single import AnyModel
from app.core.progress import Progress
from app.model.fit_method import Method
from app.services.fit import GroupFit
from app.services.lab.fit_table import FitTable, SampleLeaves, record_fits, tabulate_fits
from app.services.lab.method import describe_method
from app.services.lab.table_files import fits_as_text, write_fits
from widgets.common.aside import copy_aside
from widgets.common.fact_table import FactTable
from widgets.common.lab.asking import Asking
from widgets.common.lab.tables import fit_height
from widgets.common.numbers import UNKNOWN, show_count, show_with_sd
from widgets.controller import Controller

LEFT, RIGHT = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight


class TablePage(QWidget):
    """Fits every sample in every ticked channel; keeps nothing until asked to.

    Signals
    -------
    samples_asked()
        The list of samples is needed: `tabulate` shall be called.
    file_asked(str)
        A file with that ending shall be chosen: `write` shall be called.
    """

    samples_asked = Signal()
    file_asked = Signal(str)

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self.found: FitTable | None = None
        self._state: object = None
        self._asking = Asking(controller, self)
        self.which = QComboBox(self)
        self.make_button = QPushButton(self.tr("&Make table"), self)
        self.words = QLabel(self)
        self.table = FactTable(self.tr("Fits of samples and channels"), ("",), self, (LEFT,))
        self.wide = QCheckBox(self.tr("As &in the papers"), self)
        self.copy_button = QPushButton(self.tr("&Copy"), self)
        self.csv_button = QPushButton(self.tr("CS&V…"), self)
        self.tex_button = QPushButton(self.tr("LaTe&X…"), self)
        self.keep_button = QPushButton(self.tr("&Keep fits"), self)
        self._explain()
        self._lay_out()
        self._connect()
        self._tell()

    @property
    def all_leaves(self) -> bool:
        """Whether all leaves of the scan shall be samples, not those chosen above."""
        return bool(self.which.currentData() == "all")

    def tabulate(
        self,
        scan: str,
        samples: Sequence[SampleLeaves],
        channels: Sequence[str],
        model: AnyModel,
        method: Method,
    ) -> None:
        """Fit samples and channels in the worker."""
        aside = copy_aside(self._controller.project, scan)

        def work(progress: Progress) -> FitTable:
            return tabulate_fits(aside, scan, samples, channels, model, method, progress)

        self._asking.ask(self.tr("Fitting samples and channels"), work, self._take)

    def follow(self) -> None:
        """Say when leaves or channels have changed since the table was made."""
        self._tell()

    def write(self, path: Path) -> None:
        """Write the table; the dialog has asked about a file that exists."""
        if self.found is None:
            return
        report, wide = self.found.report, self.wide.isChecked()
        if self._controller.attempt(lambda: write_fits(report, path, wide=wide, overwrite=True)):
            self._controller.said.emit(self.tr("Fits written to {0}.").format(path))

    def copy(self) -> None:
        """Put the table on the clipboard, for a spreadsheet."""
        if self.found is not None:
            text = fits_as_text(self.found.report, "tsv", wide=self.wide.isChecked())
            QGuiApplication.clipboard().setText(text)

    def keep(self) -> None:
        """Keep all fits in the document, as one step."""
        table, project = self.found, self._controller.project
        if table is not None:
            self._controller.attempt(lambda: record_fits(project, table))

    def forget(self) -> None:
        """Let go of the table."""
        self._asking.cancel()
        self.found = None
        self._fill()

    def _take(self, table: FitTable) -> None:
        self.found = table
        self._state = self._read_state()
        self._fill()

    def _read_state(self) -> object:
        """What the table depends on, near enough to say when it may be out of date."""
        state = self._controller.project.state
        if self.found is None or self.found.scan not in state.scans:
            return None
        scan = state.scan(self.found.scan)
        leaves = tuple(id(leaf.members) for leaf in state.leaves_of(self.found.scan))
        parameters = scan.parameters
        return (
            leaves, id(scan.deleted), scan.channels, parameters.radiometry, parameters.radius,
            parameters.estimator, scan.scan.pose,
        )  # fmt: skip

    def _fill(self) -> None:
        fits = () if self.found is None else self.found.report.fits
        names = [p.name for p in fits[0].model.parameters] if fits else []
        titles = [self.tr("Sample"), self.tr("Channel"), *names, "RMSE", "R²", "n"]
        self.table.title_columns(titles, (LEFT, LEFT, *[RIGHT] * (len(titles) - 2)))
        self.table.show_rows([self._write(one) for one in fits], [_tip(one) for one in fits])
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        fit_height(self.table)
        self._tell()

    def _write(self, one: GroupFit) -> tuple[str, ...]:
        labels = tuple(one.group.values())
        if one.result is None:
            blank = (UNKNOWN,) * (len(one.model.parameters) + 2)
            return (*labels, *blank, show_count(one.n))
        cells = []
        for p in one.model.parameters:
            estimate = one.result.parameters[p.name]
            if estimate.value is None:
                cells.append(self.tr("not det."))
            else:
                bound = self.tr(" (bound)") if estimate.at_bound else ""
                cells.append(show_with_sd(estimate.value, estimate.sd) + bound)
        r2 = UNKNOWN if one.result.r2 is None else f"{one.result.r2:.4f}"
        return (*labels, *cells, f"{one.result.rmse:.3g}", r2, show_count(one.n))

    def _tell(self) -> None:
        there = self.found is not None and bool(self.found.report.fits)
        for widget in (self.table, self.wide):
            widget.setVisible(there)
        for button in (self.copy_button, self.csv_button, self.tex_button, self.keep_button):
            button.setVisible(there)
        self.make_button.setText(
            self.tr("Cance&l") if self._asking.busy else self.tr("&Make table")
        )
        if self._asking.busy:
            self.words.setText(self.tr("Fitting…"))
        elif self.found is None or not there:
            self.words.setText(
                self.tr("Every sample is fitted in every ticked channel with the model above.")
            )
        else:
            self.words.setText(self._describe(self.found))

    def _describe(self, table: FitTable) -> str:
        fits = table.report.fits
        failed = sum(one.result is None for one in fits)
        said = self.tr("1 fit") if len(fits) == 1 else self.tr("{n} fits")
        text = self.tr("{model}, {method}: {fits}").format(
            model=fits[0].model.title,
            method=describe_method(table.method),
            fits=said.format(n=show_count(len(fits))),
        )
        if failed:
            text += self.tr(", {n} of them impossible (their tool tip says why)").format(n=failed)
        if self._read_state() != self._state:
            text += self.tr(". ⚠ Leaves, channels or angles have changed since: make it anew")
        return text + "."

    def _refuse(self, sentence: str) -> None:
        self.words.setText(sentence)

    def _on_make(self) -> None:
        if self._asking.busy:
            self._asking.cancel()
        else:
            self.samples_asked.emit()

    def _on_csv(self) -> None:
        self.file_asked.emit(".csv")

    def _on_tex(self) -> None:
        self.file_asked.emit(".tex")

    def _connect(self) -> None:
        self.make_button.clicked.connect(self._on_make)
        self.copy_button.clicked.connect(self.copy)
        self.csv_button.clicked.connect(self._on_csv)
        self.tex_button.clicked.connect(self._on_tex)
        self.keep_button.clicked.connect(self.keep)
        self._asking.changed.connect(self._tell)
        self._asking.refused.connect(self._refuse)

    def _explain(self) -> None:
        self.which.addItem(self.tr("Points chosen above"), "above")
        self.which.addItem(self.tr("All leaves of the scan"), "all")
        self.which.setAccessibleName(self.tr("Samples of the table"))
        self.which.setToolTip(self.tr("Which samples become rows"))
        self.words.setWordWrap(True)
        self.wide.setToolTip(
            self.tr("A row per sample and the channels side by side, in copies and files")
        )
        for button, tip in (
            (self.make_button, self.tr("Fit all samples and channels; keeps nothing yet")),
            (self.copy_button, self.tr("Copy the table, for a spreadsheet")),
            (self.csv_button, self.tr("Write the table as CSV")),
            (self.tex_button, self.tr("Write the table for LaTeX (booktabs)")),
            (self.keep_button, self.tr("Keep these fits in the session, as one step of undo")),
        ):
            button.setToolTip(tip)

    def _lay_out(self) -> None:
        top = QGridLayout()
        top.addWidget(self.which, 0, 0)
        top.addWidget(self.make_button, 0, 1)
        top.setColumnStretch(0, 1)
        buttons = QGridLayout()
        for place, button in enumerate(
            (self.copy_button, self.csv_button, self.tex_button, self.keep_button)
        ):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(top)
        for widget in (self.words, self.table, self.wide):
            layout.addWidget(widget)
        layout.addLayout(buttons)
        layout.addStretch(1)


def _tip(one: GroupFit) -> str:
    return "\n".join(one.warnings) or ", ".join(one.group.values())
