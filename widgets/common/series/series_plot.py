"""Means of leaves against angle or time, a line per leaf in its colour."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from app.core.fitting import FitResult
from app.core.units import to_radians
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.plots import Plot

Pairs = Mapping[str, tuple[list[float], list[float]]]
STEPS = 90


class SeriesPlot(Plot):
    """Points and lines; dashed where a model was fitted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        self._pairs: Pairs = {}
        self._fits: Mapping[str, FitResult] = {}
        self._leaf = ""
        super().__init__("Leaves over angle or time", "", "", parent)

    def show_pairs(
        self, pairs: Pairs, x: str, y: str, leaf: str, fits: Mapping[str, FitResult]
    ) -> None:
        """Draw pairs by leaf; `leaf` stands out; fits are curves over degrees."""
        self.title_axis("bottom", x)
        self.title_axis("left", y)
        self._pairs, self._leaf, self._fits = pairs, leaf, fits
        self._draw()

    def restyle(self) -> None:
        """Take over the palette."""
        super().restyle()
        if self._pairs:
            self._draw()

    def _draw(self) -> None:
        self.clear()
        for leaf, (x, y) in self._pairs.items():
            colour, width = colour_of_leaf(leaf), 3.0 if leaf == self._leaf else 1.5
            fitted = self._fits.get(leaf)
            curve = pg.PlotDataItem(
                x, y, pen=None if fitted else self.pen(colour, width), symbol="o",
                symbolSize=self.dot_size() * 2.0, symbolBrush=colour,
                symbolPen=self.pen(self.ink, 0.5),
            )  # fmt: skip
            self.addItem(curve)
            if fitted is not None:
                angle = np.linspace(min(x), max(x), STEPS)
                value = fitted.evaluate(to_radians(angle))
                self.addItem(pg.PlotDataItem(angle, value, pen=self.pen(colour, width, True)))
        self.autoRange()
