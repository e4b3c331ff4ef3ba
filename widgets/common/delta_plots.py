"""Pictures of Δω: the leaf as the scanner saw it, and how its angles are spread."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from app.core.units import to_degrees
from app.core.wrinkles import Distribution
from app.render.palettes import colours
from widgets.common.plots import Plot
from widgets.common.wrinkle_map import SeenLeaf, paint


class DeltaMap(Plot):
    """Δω of a leaf over azimuth and elevation."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "", "", parent)
        self.setAccessibleName(self.tr("Map of Δω as the scanner saw the leaf"))
        self.title_axis("bottom", self.tr("Azimuth (°)"))
        self.title_axis("left", self.tr("Elevation (°)"))
        self.image = pg.ImageItem(axisOrder="row-major")
        self.addItem(self.image)
        self.setAspectLocked(True)

    def show_leaf(self, seen: SeenLeaf, limit: float) -> None:
        """Show a leaf; colours end at ±`limit` degrees."""
        (left, right), (low, high) = seen.azimuth, seen.elevation
        self.image.setImage(paint(seen, limit), levels=(0, 255))
        self.image.setRect(QRectF(left, low, right - left, high - low))
        self.autoRange(padding=0.08)


class DeltaHistogram(Plot):
    """Share of the points per degree of Δω, with its smooth shape, mean and median."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "Δω (°)", "", parent)
        self.setAccessibleName(self.tr("Distribution of Δω"))
        self.title_axis("left", self.tr("Points (% per °)"))
        self._bars = pg.BarGraphItem(x=[0.0], height=[0.0], width=1.0)
        self._smooth = pg.PlotDataItem()
        self._mean = pg.InfiniteLine(angle=90)
        self._median = pg.InfiniteLine(angle=90)
        self._legend = self.addLegend(offset=(-4, 4))
        for item in (self._bars, self._smooth, self._mean, self._median):
            self.addItem(item)

    def show_distribution(self, spread: Distribution, limit: float) -> None:
        """Show a distribution; the colours of the bars are those of the map."""
        edges = to_degrees(spread.edges)
        middles = (edges[:-1] + edges[1:]) / 2
        brushes = [
            pg.mkBrush(*(int(c) for c in rgba))
            for rgba in colours(middles, -limit, limit, "delta-omega")
        ]
        self._bars.setOpts(x=middles, height=100 * spread.fraction, width=1.0, brushes=brushes,
                           pen=None)  # fmt: skip
        faint = QColor(self.ink)
        self._smooth.setData(middles, 100 * spread.smooth, pen=self.pen(self.ink, 1.5))
        marks = ((self._mean, spread.mean, False), (self._median, spread.median, True))
        for line, angle, dashed in marks:
            line.setPos(float(to_degrees(angle)))
            line.setPen(self.pen(faint, 1.5, dashed))
        self._name_lines()
        reach = min(max(limit, float(np.abs(edges).max())), 2 * limit)
        self.setXRange(-reach, reach, padding=0.03)
        self.setYRange(0.0, 125 * float(spread.fraction.max()), padding=0.0)

    def _name_lines(self) -> None:
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        for line, title in ((self._mean, self.tr("mean")), (self._median, self.tr("median"))):
            sample = pg.PlotDataItem(pen=line.pen)
            self._legend.addItem(sample, title)
