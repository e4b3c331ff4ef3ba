"""The table of a series: measured in the worker, drawn, exported, and fitted."""

from __future__ import annotations

from collections.abc import Hashable
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.core.fitting import FitResult
from app.core.progress import Progress
from app.model.fields import Same
from app.model.series import Series
from app.services.curves import DEFAULT_MODEL
from app.services.fit import FitReport
from app.services.lab.own_models import models_at_hand
from app.services.leaves import Row, write_table
from app.services.series.document import measure_series
from app.services.series.fitting import ANGLES, fit_series, list_channels, list_pairs
from widgets.common.aside import copy_aside
from widgets.common.fact_table import FactTable
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.notice import Notice
from widgets.common.numbers import UNKNOWN, show_count, show_number, show_with_sd
from widgets.common.series.finder import mark_scan
from widgets.common.series.scan_steps import set_slim
from widgets.common.series.series_plot import SeriesPlot
from widgets.controller import Controller

RIGHT, LEFT = Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft
LINES = 7


class TablePage(QWidget):
    """Leaf × angle or time × channel, and what follows from it.

    Signals
    -------
    export_asked()
        The rows are to be written to a file.
    """

    export_asked = Signal()

    def __init__(self, controller: Controller, parent: QWidget) -> None:
        super().__init__(parent)
        self._controller = controller
        self._key = ""
        self.rows: list[Row] = []
        self._rows_of: Hashable = None
        self._fitted: tuple[Hashable, FitReport] | None = None
        self.notice = Notice(self)
        self.measure_button = QPushButton(self.tr("&Measure"), self)
        self.export_button = QPushButton(self.tr("&Export table…"), self)
        self.full_hits = QCheckBox(self.tr("F&ull hits only"), self)
        self.channel, self.against, self.model = (QComboBox(self) for _ in range(3))
        self.plot = SeriesPlot(self)
        right = (LEFT, *(RIGHT,) * 4)
        titles = (self.tr("Leaf"), "", self.tr("ω (°)"), self.tr("Mean"), self.tr("Points"))
        self.table = FactTable(self.tr("Leaves over angle or time"), titles, self, right)
        self.fit_button = QPushButton(self.tr("F&it this table"), self)
        self.fits = FactTable(
            self.tr("Fits of the leaves"), (self.tr("Leaf"), self.tr("Parameters"), "RMSE", "n"),
            self, (LEFT, LEFT, RIGHT, RIGHT),
        )  # fmt: skip
        set_slim(self.table)
        set_slim(self.fits)
        self._fill()
        self._explain()
        self._lay_out()
        self._connect()

    def _fill(self) -> None:
        for title, name in (
            (self.tr("ω, leaf as carried (°)"), ANGLES[0]),
            (self.tr("ω, plane in each scan (°)"), ANGLES[1]),
            (self.tr("Angle of the holder (°)"), "angle_deg"),
            (self.tr("Time (h)"), "hours"),
        ):
            self.against.addItem(title, name)
        for model in models_at_hand().values():
            self.model.addItem(model.title, model.name)
        self.model.setCurrentIndex(self.model.findData(DEFAULT_MODEL))

    def _explain(self) -> None:
        self.measure_button.setProperty("primary", "true")
        self.fits.explain_columns(
            self.tr("Leaf of the reference scan"),
            self.tr("Parameters ± standard error; (!): rest the mouse on the row to read why"),
            self.tr("Root of the mean square of what the curve leaves over, in the channel's unit"),
            self.tr("Scans that were fitted"),
        )
        self.table.explain_columns(
            self.tr("Leaf of the reference scan"),
            self.tr("Angle of the holder, or the hours of the scan"),
            self.tr("Angle between the beam and the normal of the leaf, degrees"),
            self.tr("Mean ± standard deviation of the points in the chosen channel"),
            self.tr("Points of the leaf in this scan"),
        )
        for widget, tip in (
            (self.measure_button, self.tr("Find every leaf in every scan and measure it")),
            (self.export_button, self.tr("Write all columns as CSV: the table that the command "
                                         "leafscope series writes")),
            (self.full_hits, self.tr("Leave out points that the beam hits only in part; needs "
                                     "rows, columns and the instrument")),
            (self.channel, self.tr("Whose means are shown and fitted")),
            (self.against, self.tr("What they are drawn against; a fit needs an angle ω")),
            (self.model, self.tr("The model that is fitted to each leaf")),
            (self.fit_button, self.tr("Fit the model to the means of each leaf over ω")),
        ):  # fmt: skip
            widget.setToolTip(tip)

    def _lay_out(self) -> None:
        form = QFormLayout()
        for title, box in (
            (self.tr("&Channel"), self.channel),
            (self.tr("A&gainst"), self.against),
        ):
            _name(form, title, box)
        line = QHBoxLayout()
        line.addWidget(self.measure_button)
        line.addWidget(self.full_hits)
        line.addStretch(1)
        last = QFormLayout()
        _name(last, self.tr("M&odel"), self.model)
        buttons = QHBoxLayout()
        buttons.addWidget(self.fit_button)
        buttons.addWidget(self.export_button)
        buttons.addStretch(1)
        self.body = QWidget(self)
        inner = QVBoxLayout(self.body)
        inner.setContentsMargins(0, 0, 0, 0)
        inner.addLayout(form)
        inner.addWidget(self.plot)
        inner.addWidget(self.table, 1)
        inner.addLayout(last)
        inner.addLayout(buttons)
        inner.addWidget(self.fits)
        em = self.fontMetrics().height()
        self.table.setMinimumHeight(LINES * em)
        self.fits.setMinimumHeight(LINES * em)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addLayout(line)
        layout.addWidget(self.notice)
        layout.addWidget(self.body, 1)

    def _connect(self) -> None:
        self.measure_button.clicked.connect(self.measure)
        self.notice.clicked.connect(self.measure)
        self.export_button.clicked.connect(self.export_asked)
        self.fit_button.clicked.connect(self.fit)
        for box in (self.channel, self.against):
            box.activated.connect(self._on_choice)

    # What is shown

    @property
    def series(self) -> Series | None:
        """The series that is shown, as it is now."""
        return self._controller.project.state.series.get(self._key)

    def refresh(self, series: Series) -> None:
        """Show the table of a series, as far as it was measured."""
        if self._key != series.key:
            self.rows, self._rows_of, self._fitted = [], None, None
            turns = len({entry.angle_deg for entry in series.entries} - {None}) > 1
            self.against.setCurrentIndex(0 if turns else self.against.findData("hours"))
        self._key = series.key
        stale = bool(self.rows) and self._rows_of != self._mark(series)
        told = self.tr("The series has changed since this was measured.") if stale else ""
        self.notice.say(told, self.tr("Measure again") if stale else "")
        self.body.setVisible(bool(self.rows))
        self._offer_channels()
        self._show()

    def forget(self) -> None:
        """Let go of a document that is gone."""
        self._key, self.rows, self._rows_of, self._fitted = "", [], None, None

    def _mark(self, series: Series) -> Hashable:
        project = self._controller.project
        parts = (
            (mark_scan(project, series, e.scan), e.hours, e.treatment, e.label,
             Same(project.state.scan(e.scan).parameters))
            for e in series.entries
        )  # fmt: skip
        return (*parts, self.full_hits.isChecked())

    def _offer_channels(self) -> None:
        offered = list_channels(self.rows)
        box = self.channel
        if [box.itemText(k) for k in range(box.count())] != offered:
            kept = box.currentText()
            box.clear()
            box.addItems(offered)
            box.setCurrentIndex(max(box.findText(kept), 0))

    def _show(self) -> None:
        channel, x = self.channel.currentText(), str(self.against.currentData())
        pairs = list_pairs(self.rows, x, f"{channel}_mean")
        fits = self._current_fits() if x in ANGLES else {}
        leaf = self._controller.view.leaf or ""
        self.plot.show_pairs(pairs, self.against.currentText(), channel, leaf, fits)
        timed = x == "hours"
        header = self.table.horizontalHeaderItem(1)
        if header is not None:
            header.setText(self.tr("Hours") if timed else self.tr("Angle (°)"))
        column = x if x in ANGLES else ANGLES[0]
        self.table.show_rows(
            [_write(row, channel, "hours" if timed else "angle_deg", column) for row in self.rows],
            [str(row.get("reason") or row.get("file") or "") for row in self.rows],
        )
        for number, row in enumerate(self.rows):
            item = self.table.item(number, 0)
            if item is not None:
                item.setData(Qt.ItemDataRole.DecorationRole, colour_of_leaf(str(row["leaf"])))
        self.fit_button.setEnabled(x in ANGLES and bool(pairs))
        self._show_fits()

    def _show_fits(self) -> None:
        report = self._report()
        self.fits.setVisible(report is not None)
        if report is not None:
            rows = [
                [fit.group["name"], _tell(fit.result) + (" (!)" if fit.warnings else ""),
                 UNKNOWN if fit.result is None else f"{fit.result.rmse:.3g}", str(fit.n)]
                for fit in report.fits
            ]  # fmt: skip
            self.fits.show_rows(rows, [" ".join(fit.warnings) or rows[k][1]
                                       for k, fit in enumerate(report.fits)])  # fmt: skip

    def _report(self) -> FitReport | None:
        """The fits, if they belong to what is shown."""
        if self._fitted is None or self._fitted[0] != self._fit_mark():
            return None
        return self._fitted[1]

    def _current_fits(self) -> dict[str, FitResult]:
        report = self._report()
        fits = () if report is None else report.fits
        return {fit.group["leaf"]: fit.result for fit in fits if fit.result is not None}

    def _fit_mark(self) -> Hashable:
        return Same(self.rows), self.channel.currentText(), self.against.currentData()

    # What the user does

    def measure(self) -> None:
        """Measure the series in the worker."""
        series = self.series
        if series is None:
            return
        project, mark = self._controller.project, self._mark(series)
        aside, full_hits = copy_aside(project, series.reference), self.full_hits.isChecked()

        def work(progress: Progress) -> list[Row]:
            return measure_series(aside, series.key, full_hits=full_hits, progress=progress)

        def done(rows: list[Row]) -> None:
            if project is self._controller.project and self.series is not None:
                self.rows, self._rows_of = rows, mark
                self.refresh(self.series)

        self._controller.run(self.tr("Measuring {series}").format(series=series.name), work, done)

    def export(self, path: Path) -> None:
        """Write the table with all its columns; an existing file is replaced."""
        if self._controller.attempt(lambda: write_table(self.rows, path, overwrite=True)):
            text = self.tr("{n} rows written to {path}.")
            self._controller.said.emit(text.format(n=show_count(len(self.rows)), path=path))

    def fit(self) -> None:
        """Fit the model to each leaf, in the worker."""
        rows, mark = self.rows, self._fit_mark()
        channel, angle = self.channel.currentText(), str(self.against.currentData())
        model = str(self.model.currentData())

        def work(progress: Progress) -> FitReport:
            return fit_series(rows, channel, model, angle, progress)

        def done(report: FitReport) -> None:
            self._fitted = (mark, report)
            self._show()

        self._controller.run(self.tr("Fitting the series"), work, done)

    def _on_choice(self, _: int) -> None:
        self._show()


def _name(form: QFormLayout, title: str, box: QComboBox) -> None:
    box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
    box.setMinimumContentsLength(8)
    box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
    box.setAccessibleName(title.replace("&", ""))
    form.addRow(title, box)


def _write(row: Row, channel: str, first: str, angle: str) -> list[str]:
    return [
        str(row["name"]),
        _show(row.get(first), 1),
        _show(row.get(angle), 1),
        show_with_sd(_number(row.get(f"{channel}_mean")), _number(row.get(f"{channel}_sd"))),
        show_count(int(_number(row.get("points")) or 0)),
    ]


def _number(value: str | float | int | None) -> float | None:
    return float(value) if isinstance(value, (int, float)) else None


def _show(value: str | float | int | None, decimals: int) -> str:
    return show_number(_number(value), decimals)


def _tell(result: FitResult | None) -> str:
    if result is None:
        return UNKNOWN
    return ", ".join(
        f"{name} = {show_with_sd(one.value, one.sd)}" for name, one in result.parameters.items()
    )
