"""A calibration that was fitted: plots, parameters, errors per panel, and what to do with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.core.radiometry.joint import JointFit
from app.core.radiometry.residuals import MaterialScore
from app.services.calibrate import CalibrationReport, ChannelReport
from widgets.common.calibration.fit_plot import FitPlot
from widgets.common.calibration.profile_words import describe_limits, show_share
from widgets.common.fact_table import FactTable
from widgets.common.numbers import UNKNOWN, show_signed

FEW_LEFT = 3
LEFT, RIGHT = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight


class FitView(QWidget):
    """Shows what came of a calibration.

    Signals
    -------
    use_asked(), save_asked(), report_asked()
    """

    use_asked = Signal()
    save_asked = Signal()
    report_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.report: CalibrationReport | None = None
        self._unusable = 0
        self._colours: Mapping[str, QColor] = {}
        self.sentence, self.aside = QLabel(self), QLabel(self)
        self.channel, self.what = QComboBox(self), QComboBox(self)
        self.plot = FitPlot(self)
        self.parameters = FactTable(
            self.tr("Parameters of the calibration"),
            (self.tr("Parameter"), self.tr("Value"), self.tr("95 % interval")),
            self,
            (LEFT, RIGHT, RIGHT),
        )
        self.panels = FactTable(
            self.tr("Errors of each panel"),
            (self.tr("Panel"), self.tr("RMSE"), self.tr("Bias"), self.tr("Left out")),
            self,
            (LEFT, RIGHT, RIGHT, RIGHT),
        )
        self.use_button = QPushButton(self.tr("&Use this profile"), self)
        self.save_button = QPushButton(self.tr("Sa&ve profile…"), self)
        self.report_button = QPushButton(self.tr("Save repor&t…"), self)
        self._fill()
        self._lay_out()
        self.what.activated.connect(self._draw)
        self.channel.activated.connect(self._show_channel)
        self.use_button.clicked.connect(self.use_asked)
        self.save_button.clicked.connect(self.save_asked)
        self.report_button.clicked.connect(self.report_asked)

    def show_report(
        self,
        report: CalibrationReport | None,
        unusable: int = 0,
        colours: Mapping[str, QColor] = MappingProxyType({}),
    ) -> None:
        """Show a calibration; None hides all.

        Parameters
        ----------
        unusable : int
            Panels that never came to the fit.
        colours : mapping of str to QColor
            Of panels, where they have some elsewhere.
        """
        self.report, self._unusable, self._colours = report, unusable, colours
        self.setVisible(report is not None)
        if report is None:
            return
        self.channel.clear()
        for each in report.channels:
            self.channel.addItem(each.channel.name)
        self.channel.setVisible(len(report.channels) > 1)
        self._show_channel()

    @property
    def shown(self) -> ChannelReport | None:
        """The channel that is looked at."""
        return None if self.report is None else self.report.channels[self.channel.currentIndex()]

    def _show_channel(self, _: int = 0) -> None:
        shown = self.shown
        if shown is None:
            return
        self._draw()
        self.sentence.setText(self._tell(shown))
        warnings = self._warn(shown)
        self.aside.setText("\n".join(f"⚠ {sentence}" for sentence in warnings))
        self.aside.setVisible(bool(warnings))
        self.parameters.show_rows(list_parameters(shown.calibration.fit))
        self.panels.show_rows(*list_panels(shown.scores))
        for table in (self.parameters, self.panels):
            _fit_height(table)

    def _tell(self, shown: ChannelReport) -> str:
        evidence = shown.channel.evidence
        if evidence is None:
            return ""
        text = self.tr("<b>{profile}</b><br>{name}: RMSE {rmse}, bias {bias}<br>{n} rows, {limits}")
        return text.format(
            profile="" if self.report is None else self.report.profile.name,
            name=shown.channel.name,
            rmse=show_share(evidence.rmse),
            bias=_show_signed_share(evidence.bias),
            n=evidence.rows,
            limits=describe_limits(shown.channel),
        )

    def _warn(self, shown: ChannelReport) -> list[str]:
        found, said = shown.calibration, []
        left_out = found.dark + found.saturated + self._unusable
        if left_out:
            said.append(self.tr("Dark or saturated, and left out: {n}.").format(n=left_out))
        if len(found.table.scans) > 1 and not found.fixed_panels:
            said.append(self.tr(
                "No panel is in all scans at one range: the laser's power is taken for the same "
                "in all of them."
            ))  # fmt: skip
        if found.model.range_effect is None and shown.channel.nearest is not None:
            said.append(self.tr(
                "Without a range effect it holds only near the ranges of the panels. If the "
                "instrument has taken the range out, say so under the limits."
            ))  # fmt: skip
        if not found.table.reflectance_sigma.any():
            said.append(
                self.tr("The panels are taken as exactly known: give their ± σ if they are not.")
            )
        if found.fit.freedom < FEW_LEFT:
            said.append(self.tr("Few panels for so many parameters: the intervals are wide."))
        return said

    def _draw(self, _: int = 0) -> None:
        if self.shown is not None:
            self.plot.show_fit(self.shown.calibration, self.what.currentData(), self._colours)

    def _fill(self) -> None:
        for title, data in (
            (self.tr("DN against reflectance"), "reflectance"),
            (self.tr("DN against range"), "range"),
            (self.tr("Residuals against range"), "residual-range"),
            (self.tr("Residuals against reflectance"), "residual-reflectance"),
        ):
            self.what.addItem(title, data)
        self.what.setAccessibleName(self.tr("What is drawn"))
        self.channel.setAccessibleName(self.tr("Calibrated channel"))
        self.what.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.use_button.setProperty("primary", "true")
        self.use_button.setToolTip(self.tr("Reflectance of this scan comes from it; can be undone"))
        self.save_button.setToolTip(self.tr("Keep it as a TOML file for other scans"))
        self.report_button.setToolTip(self.tr("Parameters, errors and how they were found"))
        self.panels.explain_columns(
            "",
            self.tr("Root of the mean squared error of the reflectance"),
            self.tr("Mean error of the reflectance"),
            self.tr("RMSE from a fit that did not see this panel"),
        )
        for label in (self.sentence, self.aside):
            label.setWordWrap(True)
        self.aside.setProperty("faint", "true")

    def _lay_out(self) -> None:
        buttons = QGridLayout()
        buttons.addWidget(self.use_button, 0, 0, 1, 2)
        buttons.addWidget(self.save_button, 1, 0)
        buttons.addWidget(self.report_button, 1, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (
            self.channel, self.sentence, self.what, self.plot, self.parameters, self.panels,
            self.aside,
        ):  # fmt: skip
            layout.addWidget(widget)
        layout.addLayout(buttons)


def list_parameters(fit: JointFit) -> list[tuple[str, str, str]]:
    """Name, value and interval of each parameter."""
    rows = zip(fit.found.names, fit.found.natural(), fit.low, fit.high, strict=True)
    return [
        (name, _show(value), f"{_show(low)} … {_show(high)}") for name, value, low, high in rows
    ]


def list_panels(scores: Sequence[MaterialScore]) -> tuple[list[tuple[str, ...]], list[str]]:
    """Texts and tool tips of the errors of each panel, in percent of reflectance."""
    rows: list[tuple[str, ...]] = []
    tips = []
    for score in scores:
        out = score.left_out_rmse
        left_out = UNKNOWN if out is None else show_share(out)
        rows.append((score.panel, show_share(score.rmse), _show_signed_share(score.bias), left_out))
        tips.append(
            f"{show_share(score.reflectance)}: {score.dn_rmse:.3g} DN RMSE, "
            f"{score.dn_bias:+.3g} DN bias, {score.rows} rows"
        )
    return rows, tips


def _show_signed_share(value: float) -> str:
    return f"{show_signed(round(100.0 * value, 2) + 0.0, 2)} %"


def _show(value: float) -> str:
    return f"{value:.5g}".replace("-", "−")


def _fit_height(table: FactTable) -> None:
    """As high as its rows, up to a dozen."""
    rows = min(table.rowCount(), 12)
    heights = sum(table.rowHeight(row) for row in range(rows))
    table.setFixedHeight(heights + table.horizontalHeader().sizeHint().height() + 4)
    table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
