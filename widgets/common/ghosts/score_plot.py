"""Histogram of the ghost score with the threshold as a line that can be dragged."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from app.core.arrays import AnyArray
from app.core.units import group_digits
from app.render.palettes import FLAG
from widgets.common.plots import Plot

LEAST_SHARE = 0.5


class ScorePlot(Plot):
    """Points per hundredth of the score, on a log scale; ghosts in the colour of ghosts.

    Signals
    -------
    moved(float), released(float)
        The line is being dragged; it was let go.
    """

    moved = Signal(float)
    released = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("", "", "", parent)
        self.setAccessibleName(self.tr("Histogram of the ghost score"))
        self.title_axis("bottom", self.tr("Ghost score (0–1)"))
        self.title_axis("left", self.tr("Points"))
        self._bars = pg.BarGraphItem(x=[0.0], height=[0.0], width=0.01)
        self.line = pg.InfiniteLine(0.5, angle=90, movable=True, bounds=(0.0, 1.0))
        self.addItem(self._bars)
        self.addItem(self.line)
        self._counts: AnyArray = np.zeros(0)
        self._tops: AnyArray = np.zeros(0)
        self.setMouseEnabled(x=False, y=False)
        self.setXRange(0.0, 1.0, padding=0.04)
        self.getAxis("left").setTicks([[]])
        self.line.sigDragged.connect(self._on_dragged)
        self.line.sigPositionChangeFinished.connect(self._on_let_go)

    def show_counts(self, histogram: AnyArray, threshold: float) -> None:
        """Show points per bin; a log scale, since ghosts are few among many."""
        self._counts = histogram
        top = max(float(np.log10(max(histogram.max(initial=1), 1))), 1.0)
        self._tops = np.where(histogram > 0, np.log10(np.maximum(histogram, 1)) + LEAST_SHARE, 0.0)
        decades = range(int(top) + 1)
        self.getAxis("left").setTicks([[(d + LEAST_SHARE, group_digits(10**d)) for d in decades]])
        self.setYRange(0.0, top + 2 * LEAST_SHARE, padding=0.0)
        self.show_threshold(threshold)

    def show_threshold(self, threshold: float) -> None:
        """Move the line and colour the bars on both sides of it."""
        self.line.setValue(threshold)
        self.line.setPen(self.pen(self.ink, 2.0, dashed=True))
        self.line.setHoverPen(self.pen(self.accent, 3.0))
        bins = len(self._counts)
        if bins == 0:
            return
        middles = (np.arange(bins) + 0.5) / bins
        brushes = [pg.mkBrush(FLAG[int(m >= threshold)]) for m in middles]
        self._bars.setOpts(x=middles, height=self._tops, width=0.9 / bins, brushes=brushes,
                           pen=None)  # fmt: skip

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if hasattr(self, "line"):
            self.show_threshold(self.line.value())

    def _on_dragged(self, line: pg.InfiniteLine) -> None:
        self.moved.emit(float(line.value()))

    def _on_let_go(self, line: pg.InfiniteLine) -> None:
        self.released.emit(float(line.value()))
