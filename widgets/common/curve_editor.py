"""A curve: its parameters as sliders, and what there is to say about it."""

from __future__ import annotations

import math
from collections.abc import Mapping

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.core.fitting import FitResult
from app.core.phase import MODELS
from app.core.phase.angular import AngularModel
from widgets.common.angular_plot import AngularPlot
from widgets.common.angular_points import NO_POINTS, AngularPoints
from widgets.common.lab.plots_view import PlotsView
from widgets.common.lab.series import Shape
from widgets.common.lab.start import start_curve
from widgets.common.numbers import show_count, show_number
from widgets.common.parameter_rows import ParameterRows


class CurveEditor(QWidget):
    """Shows one curve of one model; sliders move it, nothing else happens.

    Signals
    -------
    moved(), released()
        A parameter is being changed by hand; it was let go.
    """

    moved = Signal()
    released = Signal()

    def __init__(self, plots: PlotsView, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._plots = plots
        self.rows = ParameterRows(self)
        self.formula = _make_label(self, quiet=True)
        self.facts = _make_label(self)
        self.stale = _make_label(self)
        self.warnings = _make_label(self)
        self.points = NO_POINTS
        self.result: FitResult | None = None
        self._method = ""
        self._model: AngularModel | None = None
        self._wanted: Mapping[str, float] | None = None
        self._rows_for: tuple[AngularModel, float] | None = None
        self._start: tuple[AngularModel, AngularPoints, dict[str, float]] | None = None
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (self.stale, self.rows, self.facts, self.warnings, self.formula):
            layout.addWidget(widget)
        layout.addStretch(1)
        self.stale.hide()
        self.rows.moved.connect(self._on_moved)
        self.rows.released.connect(self._on_released)

    @property
    def plot(self) -> AngularPlot:
        """The plot in which the curve is drawn."""
        return self._plots.plot

    @property
    def values(self) -> dict[str, float]:
        """Values of the curve that is shown."""
        return self.rows.values

    @property
    def shape(self) -> Shape | None:
        """The curve that is shown."""
        if self._model is None:
            return None
        scatter = None if self.result is None else self.result.rmse
        return Shape(self._model, self.values, scatter)

    def show_points(self, points: AngularPoints) -> None:
        """Take over the points that the curve belongs to."""
        self.points = points
        self._show_rows()
        self._tell()

    def show_curve(
        self,
        model: AngularModel,
        values: Mapping[str, float] | None,
        result: FitResult | None,
        method: str = "",
    ) -> None:
        """Show a curve with the fit that it comes from; no values: one to start from.

        Parameters
        ----------
        model : AngularModel
        values : mapping of str to float or None
        result : FitResult or None
        method : str
            To what it was fitted, in words.
        """
        self._model, self._wanted, self.result, self._method = model, values, result, method
        own = "" if model.name in MODELS else "I(ω) = "
        self.formula.setText(f"{own}{model.formula}")
        self.formula.setToolTip(model.source)
        self._show_rows(flying=result is not None)
        self._tell()

    def say_stale(self, sentence: str) -> None:
        """Say that the fit belongs to other points than those shown; nothing when it does not."""
        self.stale.setText(f"⚠ {sentence}" if sentence else "")
        self.stale.setVisible(bool(sentence))

    def _show_rows(self, flying: bool = False) -> None:
        if self._model is None:
            return
        size = max(abs(self.points.top), abs(self.points.bottom), 1e-12)
        if self._rows_for != (self._model, size):
            self.rows.show_model(self._model, size)
            self._rows_for = (self._model, size)
        values = self._wanted or self._find_start(self._model)
        result = self.result
        self.rows.show_values(
            values,
            None if result is None else result.parameters,
            () if result is None else result.warnings,
            flying,
        )
        self._plots.move_curve(self.shape)

    def _find_start(self, model: AngularModel) -> dict[str, float]:
        """Where the curve starts; found once for these points."""
        if self._start is None or self._start[:2] != (model, self.points):
            self._start = model, self.points, start_curve(model, self.points)
        return self._start[2]

    def _on_moved(self, values: dict[str, float]) -> None:
        fitted, self.result, self._wanted = self.result, None, values
        self._plots.move_curve(self.shape)
        if fitted is not None:  # the words change once, then only the curve moves
            self._tell()
            self.say_stale("")
        self.moved.emit()

    def _on_released(self, _: object) -> None:
        self.released.emit()

    def _tell(self) -> None:
        self.facts.setText("\n".join(filter(None, (self._tell_points(), self._tell_fit()))))
        words = () if self.result is None else self.result.warnings
        self.warnings.setText("\n".join(f"⚠ {sentence}" for sentence in words))
        self.warnings.setVisible(bool(words))

    def _tell_points(self) -> str:
        low, high = self.points.reach
        if not self.points.count:
            return self.tr("No point has both an angle and an intensity.")
        return self.tr("{n} points at {low}° to {high}°").format(
            n=show_count(self.points.count), low=show_number(low, 1), high=show_number(high, 1)
        )

    def _tell_fit(self) -> str:
        result = self.result
        if result is None:
            return self.tr("This curve was not fitted; the sliders move it.")
        low, high = (math.degrees(angle) for angle in result.angle_range)
        return self.tr(
            "Fitted to {method}: {n} values at {low}° to {high}°, RMSE {rmse}, R² {r2}, rss {rss}"
        ).format(
            method=self._method or self.tr("points"),
            n=show_count(result.n),
            low=show_number(low, 1),
            high=show_number(high, 1),
            rss=f"{result.rss:.4g}",
            rmse=f"{result.rmse:.3g}",
            r2=show_number(result.r2, 3),
        )


def _make_label(parent: QWidget, quiet: bool = False) -> QLabel:
    label = QLabel(parent)
    label.setWordWrap(True)
    label.setTextFormat(Qt.TextFormat.PlainText)
    label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    if quiet:
        label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
    return label
