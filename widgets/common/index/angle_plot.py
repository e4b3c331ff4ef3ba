"""An index against the angle: measured steps with bars, the fitted curve, its extremes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from pyqtgraph.graphicsItems.ScatterPlotItem import drawSymbol
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import QWidget

from app.core.arrays import Floats
from app.services.leaves import Row
from widgets.common.plots import GREEN, ORANGE, Plot

TICKS = range(0, 91, 15)
MARGIN = 0.08
EXTREMES = ("t", "t1")
"""Symbols of the least and the largest value."""


class IndexAnglePlot(Plot):
    """Curve ± σ of one leaf, means per 5° ± standard error, and where it is least and largest."""

    _shown: tuple[Sequence[Row], str] | None = None

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "ω (°)", "", parent)
        self.setAccessibleName(self.tr("Index against the angle of incidence"))
        self.setToolTip(
            self.tr(
                "Index of the channels' means per 5° ± standard error; the index of the fitted "
                "channels ± σ; where it is least and largest"
            )
        )
        self._low, self._high = pg.PlotDataItem(), pg.PlotDataItem()
        self._band = pg.FillBetweenItem(self._low, self._high)
        self.curve = pg.PlotDataItem(connect="finite")
        self._bars = pg.ErrorBarItem(x=np.zeros(0), y=np.zeros(0), height=np.zeros(0), beam=1.0)
        self.measured, self.extremes = pg.ScatterPlotItem(), pg.ScatterPlotItem()
        for item in (self._band, self._bars, self.measured, self.curve, self.extremes):
            self.addItem(item)
        self._legend = self.add_legend_above(3)
        self.getAxis("bottom").setTicks([[(angle, f"{angle}") for angle in TICKS]])
        self.setXRange(0.0, 90.0, padding=0.03)

    def show_curves(self, rows: Sequence[Row], title: str) -> None:
        """Show the curves of one leaf; `title` names the index."""
        self._shown = (rows, title)
        measured, fitted = (_columns(rows, name) for name in ("measured", "fitted"))
        self.title_axis("left", title)
        band, accent = QColor(self.accent), self.accent
        band.setAlphaF(0.18)
        angle, value, sigma = fitted
        self.curve.setData(angle, value, pen=self.pen(accent, 2.5))
        self._band.setVisible(bool(len(angle)))
        if len(angle):
            self._low.setData(angle, value - sigma)
            self._high.setData(angle, value + sigma)
            self._band.setBrush(band)
        x, y, error = measured
        bars = np.where(np.isfinite(error), error, 0.0)
        self._bars.setData(x=x, y=y, height=2 * bars, pen=self.pen(ORANGE, 1.5))
        self.measured.setData(x, y, size=2.2 * self.dot_size(), symbol="s", brush=ORANGE, pen=None)
        self._mark_extremes(angle if len(angle) else x, value if len(angle) else y)
        self._fit_range(y - bars, y + bars, value)
        self._name_items(bool(len(angle)))

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if self._shown is not None:
            self.show_curves(*self._shown)

    def _mark_extremes(self, angle: Floats, value: Floats) -> None:
        known = np.flatnonzero(np.isfinite(value))
        if not len(known):
            self.extremes.setData([], [])
            return
        ends = known[[np.argmin(value[known]), np.argmax(value[known])]]
        self.extremes.setData(
            angle[ends],
            value[ends],
            symbol=list(EXTREMES),
            size=3.2 * self.dot_size(),
            brush=GREEN,
            pen=self.pen(self.palette().base().color(), 1.0),
        )

    def _fit_range(self, *values: Floats) -> None:
        known = np.concatenate([v[np.isfinite(v)] for v in values])
        if len(known):
            low, high = float(known.min()), float(known.max())
            reach = max(high - low, 1e-6)
            self.setYRange(low - MARGIN * reach, high + MARGIN * reach, padding=0.0)

    def _name_items(self, fitted: bool) -> None:
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        self._legend.addItem(self.measured, self.tr("means"))
        if fitted:
            self._legend.addItem(self.curve, self.tr("curve"))
        self._legend.addItem(ExtremesSample(self.extremes), self.tr("min, max"))


class ExtremesSample(pg.ItemSample):  # type: ignore[misc]
    """Both triangles side by side: a legend's own sample knows one symbol."""

    def paint(self, painter: QPainter, *_: Any) -> None:
        """Draw them."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for place, symbol in zip((4.5, 15.5), EXTREMES, strict=True):
            painter.save()  # drawing a symbol leaves the painter scaled
            painter.translate(place, 10.0)
            drawSymbol(painter, symbol, 9.0, pg.mkPen(None), pg.mkBrush(GREEN))
            painter.restore()


def _columns(rows: Sequence[Row], curve: str) -> tuple[Floats, Floats, Floats]:
    """Angle, index and σ of one kind of curve; NaN where there is none."""
    mine = [row for row in rows if row["curve"] == curve]
    found = (
        np.array([np.nan if row[key] is None else row[key] for row in mine], dtype=np.float64)
        for key in ("angle_deg", "index", "sigma")
    )
    angle, value, sigma = found
    return angle, value, sigma
