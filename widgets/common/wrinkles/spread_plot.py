"""How the Δω of a leaf are spread, with its peaks."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from app.core.units import to_degrees
from app.core.wrinkles import Distribution
from app.render.palettes import colours
from widgets.common.plots import Plot
from widgets.common.wrinkles.rasters import PALETTE

LINES = 11


class SpreadPlot(Plot):
    """Share of the points per degree of Δω, with its smooth shape, mean, median and peaks."""

    _shown: tuple[Distribution, float] | None = None

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "Δω (°)", "", parent)
        self.setAccessibleName(self.tr("Distribution of Δω"))
        self.title_axis("left", self.tr("Points (% per °)"))
        self.setMinimumHeight(self.fontMetrics().height() * LINES)
        self._bars = pg.BarGraphItem(x=[0.0], height=[0.0], width=1.0)
        self._smooth = pg.PlotDataItem()
        self._mean = pg.InfiniteLine(angle=90)
        self._median = pg.InfiniteLine(angle=90)
        self.peaks = pg.ScatterPlotItem(symbol="t", size=1.6 * self.dot_size() + 4)
        self._legend = self.add_legend_above(3)
        for item in (self._bars, self._smooth, self._mean, self._median, self.peaks):
            self.addItem(item)

    def show_distribution(self, spread: Distribution, limit: float) -> None:
        """Show a distribution; the colours of the bars are those of the map."""
        self._shown = (spread, limit)
        edges = to_degrees(spread.edges)
        middles = (edges[:-1] + edges[1:]) / 2
        brushes = [
            pg.mkBrush(*(int(c) for c in rgba)) for rgba in colours(middles, -limit, limit, PALETTE)
        ]
        self._bars.setOpts(x=middles, height=100 * spread.fraction, width=1.0, brushes=brushes,
                           pen=None)  # fmt: skip
        self._smooth.setData(middles, 100 * spread.smooth, pen=self.pen(self.ink, 1.5))
        for line, angle, dashed in (
            (self._mean, spread.mean, False), (self._median, spread.median, True)
        ):  # fmt: skip
            line.setPos(float(to_degrees(angle)))
            line.setPen(self.pen(self.accent, 1.5, dashed))
        highest = 100 * float(max(spread.fraction.max(), spread.smooth.max()))
        modes = to_degrees(np.array(spread.modes))
        heights = 100 * np.interp(modes, middles, spread.smooth) + 0.07 * highest
        self.peaks.setData(modes, heights, brush=pg.mkBrush(self.ink), pen=None)
        self._name_lines()
        reach = min(max(limit, float(np.abs(edges).max())), 2 * limit)
        self.setXRange(-reach, reach, padding=0.03)
        self.setYRange(0.0, 1.15 * highest, padding=0.0)

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if self._shown is not None:
            self.show_distribution(*self._shown)

    def _name_lines(self) -> None:
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        peak = pg.ScatterPlotItem(symbol="t", size=8, brush=pg.mkBrush(self.ink), pen=None)
        for item, title in (
            (pg.PlotDataItem(pen=self._mean.pen), self.tr("mean")),
            (pg.PlotDataItem(pen=self._median.pen), self.tr("median")),
            (peak, self.tr("peak")),
        ):
            self._legend.addItem(item, title)
