"""Spread of an index against the diameter of the footprint, on a logarithmic axis."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from app.services.synthetic_footprints import Spread
from widgets.common.plots import GREEN, ORANGE, Plot

HEADROOM = 1.7
"""For the legend."""
TICKS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


class SpreadPlot(Plot):
    """Standard deviation by size, the error that is to be reached, and where it is."""

    _shown: tuple[Spread, float, float | None] | None = None

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "", "", parent)
        self.setAccessibleName(self.tr("Spread of the index against the footprint"))
        self.title_axis("bottom", self.tr("Diameter (mm)"))
        self.line = pg.PlotDataItem()
        self.single, self.error = pg.InfiniteLine(angle=0), pg.InfiniteLine(angle=0)
        self.reached = pg.InfiniteLine(angle=90)
        for item in (self.line, self.single, self.error, self.reached):
            self.addItem(item)
        self._legend = self.addLegend(offset=(1, 1), colCount=2, labelTextSize="9pt")
        ticks = [(float(np.log10(mm)), f"{mm}") for mm in TICKS]
        self.getAxis("bottom").setTicks([ticks])

    def show_spread(self, found: Spread, error: float, reached_mm: float | None) -> None:
        """Show sizes of a spread; lines for the error and the size that reaches it."""
        self._shown = (found, error, reached_mm)
        rows = [row for row in found.rows if row["diameter_mm"] and row["sd"] is not None]
        x = np.log10(np.array([row["diameter_mm"] for row in rows], dtype=np.float64))
        y = np.array([row["sd"] for row in rows], dtype=np.float64)
        accent = self.accent
        self.line.setData(
            x, y, pen=self.pen(accent, 2.0), symbol="o", symbolBrush=accent, symbolPen=None,
            symbolSize=2.2 * self.dot_size(),
        )  # fmt: skip
        single = found.rows[0]["sd"]
        self.single.setVisible(single is not None)
        if single is not None:
            self.single.setPos(float(single))
        self.single.setPen(self.pen(self.ink, 1.0, dashed=True))
        self.error.setPos(error)
        self.error.setPen(self.pen(ORANGE, 1.5))
        self.reached.setVisible(bool(reached_mm))
        if reached_mm:
            self.reached.setPos(float(np.log10(reached_mm)))
        self.reached.setPen(self.pen(GREEN, 1.5))
        self.title_axis("left", self.tr("sd of {0}").format(found.index.name))
        top = max([error, float(single or 0.0), *y.tolist()])
        self.setYRange(0.0, HEADROOM * top, padding=0.0)
        if len(x):
            self.setXRange(float(x.min()), float(x.max()), padding=0.08)
        self._name_items(bool(reached_mm))

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if self._shown is not None:
            self.show_spread(*self._shown)

    def _name_items(self, reached: bool) -> None:
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        named = [(self.line, self.tr("footprints")), (self.single, self.tr("single points")),
                 (self.error, self.tr("error"))]  # fmt: skip
        if reached:
            named.append((self.reached, self.tr("size that reaches it")))
        for item, title in named:
            pen = item.opts["pen"] if isinstance(item, pg.PlotDataItem) else item.pen
            self._legend.addItem(pg.PlotDataItem(pen=pen), title)
