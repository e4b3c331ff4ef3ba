"""A curve with its points, its parameters as sliders, and what there is to say about it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.core.fitting import FitResult
from app.core.phase import PhaseModel
from widgets.common.angular_plot import AngularPlot
from widgets.common.angular_points import AngularPoints, reduce_points
from widgets.common.numbers import show_count, show_number
from widgets.common.parameter_rows import ParameterRows
from widgets.common.plots import MOST_DOTS

NO_POINTS = reduce_points(np.empty(0), np.empty(0), MOST_DOTS)


class CurveEditor(QWidget):
    """Shows one curve of one model; sliders move it, nothing else happens.

    Signals
    -------
    moved(), released()
        A parameter is being changed by hand; it was let go.
    """

    moved = Signal()
    released = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.plot = AngularPlot(self.tr("Intensity against incidence angle"), self)
        self.rows = ParameterRows(self)
        self.formula = _make_label(self, quiet=True)
        self.facts = _make_label(self)
        self.warnings = _make_label(self)
        self.points = NO_POINTS
        self.result: FitResult | None = None
        self._model: PhaseModel | None = None
        self._wanted: Mapping[str, float] | None = None
        self._rows_for: tuple[str, float] | None = None
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.plot, 1)
        for widget in (self.formula, self.rows, self.facts, self.warnings):
            layout.addWidget(widget)
        self.rows.moved.connect(self._on_moved)
        self.rows.released.connect(self._on_released)

    @property
    def values(self) -> dict[str, float]:
        """Values of the curve that is shown."""
        return self.rows.values

    def show_points(self, points: AngularPoints, title: str) -> None:
        """Show points; `title` names their values with the unit."""
        self.points = points
        self.plot.title_axis("left", title)
        self.restyle()
        self._show_rows()
        self._tell()

    def show_curve(
        self, model: PhaseModel, values: Mapping[str, float] | None, result: FitResult | None
    ) -> None:
        """Show a curve with the fit that it comes from; no values: one to start from."""
        self._model, self._wanted, self.result = model, values, result
        self.formula.setText(model.formula)
        self.formula.setToolTip(model.source)
        self._show_rows()
        self._tell()

    def restyle(self) -> None:
        """Draw in the colours of the palette."""
        self.plot.show_points(self.points)
        self._draw()

    def _show_rows(self) -> None:
        if self._model is None:
            return
        size = max(abs(self.points.top), abs(self.points.bottom), 1e-12)
        if self._rows_for != (self._model.name, size):
            self.rows.show_model(self._model, size)
            self._rows_for = (self._model.name, size)
        values = self._wanted or start_values(self._model, size)
        self.rows.show_values(values, self.result.parameters if self.result else None)
        self._draw()

    def _draw(self) -> None:
        if self._model is not None:
            scatter = None if self.result is None else self.result.rmse
            self.plot.show_curve(self._model, self.values, self.points.reach, scatter)

    def _on_moved(self, values: dict[str, float]) -> None:
        self.result, self._wanted = None, values
        self._draw()
        self._tell()
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
            "Fitted to {n} values at {low}° to {high}°: rss {rss}, RMSE {rmse}, R² {r2}"
        ).format(
            n=show_count(result.n),
            low=show_number(low, 1),
            high=show_number(high, 1),
            rss=f"{result.rss:.4g}",
            rmse=f"{result.rmse:.3g}",
            r2=show_number(result.r2, 3),
        )


def start_values(model: PhaseModel, size: float) -> dict[str, float]:
    """A usual curve for data of this size, to start from."""
    return {
        p.name: (p.typical[0] + p.typical[1]) / 2 * (size if p.scales else 1.0)
        for p in model.parameters
    }


def _make_label(parent: QWidget, quiet: bool = False) -> QLabel:
    label = QLabel(parent)
    label.setWordWrap(True)
    label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    if quiet:
        label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
    return label
