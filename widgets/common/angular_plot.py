"""Plot of intensity against incidence angle with a curve through it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from app.core.arrays import Floats
from app.core.phase import PhaseModel
from app.core.units import to_radians
from widgets.common.angular_points import AngularPoints
from widgets.common.plots import ORANGE, DensityImage, Plot, mix

STEEPEST_DRAWN = 89.9
HEADROOM = 0.15
TICKS = range(0, 91, 15)
DRAWN = np.linspace(0.0, STEEPEST_DRAWN, 361)


class AngularPlot(Plot):
    """Points or their density, means per 5°, and the curve, dashed beyond the data."""

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(name, "ω (°)", "", parent)
        self._dots = pg.ScatterPlotItem(pen=None)
        self._density = DensityImage()
        self._low = pg.PlotDataItem()
        self._high = pg.PlotDataItem()
        self._band = pg.FillBetweenItem(self._low, self._high)
        self._beyond = pg.PlotDataItem(connect="finite")
        self.curve = pg.PlotDataItem(connect="finite")
        self._bars = pg.ErrorBarItem(x=np.zeros(0), y=np.zeros(0), height=np.zeros(0), beam=1.2)
        self.means = pg.ScatterPlotItem()
        for item in (
            self._density,
            self._dots,
            self._band,
            self._bars,
            self.means,
            self._beyond,
            self.curve,
        ):
            self.addItem(item)
        self._legend = self.addLegend(offset=(-4, 4))
        self.getAxis("bottom").setTicks([[(angle, f"{angle}") for angle in TICKS]])
        self.setXRange(0.0, 90.0, padding=0.03)

    def show_points(self, points: AngularPoints) -> None:
        """Show points and their means, in the colours of the palette."""
        dots, means = points.dots, points.means
        faint = QColor(mix(self.ink, self.palette().base().color(), 0.4))
        faint.setAlphaF(0.35 if dots is not None and len(dots[0]) > 2000 else 0.6)
        x, y = dots if dots is not None else (np.zeros(0), np.zeros(0))
        self._dots.setData(x, y, size=self.dot_size(), brush=faint, pen=None)
        self._density.setVisible(points.density is not None)
        if points.density is not None:
            self._density.show_counts(*points.density)
        bars = self.pen(ORANGE, 1.5)
        self._bars.setData(x=means.angle, y=means.value, height=2 * means.sd, pen=bars)
        self.means.setData(
            means.angle,
            means.value,
            size=2.4 * self.dot_size(),
            symbol="s",
            brush=ORANGE,
            pen=self.pen(self.palette().base().color(), 1.0),
        )
        height = max(points.top - points.bottom, 1e-12)
        self.setYRange(points.bottom, points.top + HEADROOM * height, padding=0.0)

    def show_curve(
        self,
        model: PhaseModel,
        values: Mapping[str, float],
        reach: tuple[float, float],
        scatter: float | None,
    ) -> None:
        """Draw a curve: whole within the angles of the data, dashed beyond, with a band.

        Parameters
        ----------
        reach : (float, float)
            Angles of the data in degrees, NaN without data.
        scatter : float or None
            Half width of the band: the RMSE of a fit.
        """
        y = draw_curve(model, values)
        inside = (reach[0] - 0.3 <= DRAWN) & (reach[1] + 0.3 >= DRAWN)
        strong = self.accent
        self._beyond.setData(DRAWN, y, pen=self.pen(strong, 1.5, dashed=True))
        self.curve.setData(DRAWN, np.where(inside, y, np.nan), pen=self.pen(strong, 2.5))
        band = QColor(strong)
        band.setAlphaF(0.18)
        shown = scatter is not None and bool(inside.any())
        self._band.setVisible(shown)
        if scatter is not None and shown:
            self._low.setData(DRAWN[inside], y[inside] - scatter)
            self._high.setData(DRAWN[inside], y[inside] + scatter)
            self._band.setBrush(band)
        self._name_items(shown)

    def _name_items(self, banded: bool) -> None:
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        curve = self.tr("curve ± RMSE") if banded else self.tr("curve")
        self._legend.addItem(self.curve, curve)
        self._legend.addItem(self.means, self.tr("mean ± sd per 5°"))


def draw_curve(model: PhaseModel, values: Mapping[str, float]) -> Floats:
    """The curve at the angles that are drawn; NaN where it leaves the numbers."""
    with np.errstate(all="ignore"):
        y = model.evaluate(to_radians(DRAWN), values)
    return np.where(np.isfinite(y), y, np.nan)
