"""What stands in the plot for one series: means with bars, and the curve."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from pyqtgraph.graphicsItems.ScatterPlotItem import drawSymbol
from PySide6.QtGui import QColor, QPainter

from app.core.arrays import Floats
from widgets.common.lab.series import DRAWN, Series, Shape
from widgets.common.plots import Plot

MARGIN = 0.3
"""Degrees by which the drawn curve may pass the data before it is dashed."""


class SeriesItems:
    """Items of one series in one plot; moving the curve touches nothing but the curve."""

    def __init__(self, plot: Plot) -> None:
        self._plot = plot
        empty = np.zeros(0)
        self.bars = pg.ErrorBarItem(x=empty, y=empty, height=empty, beam=1.2)
        self.means = pg.ScatterPlotItem()
        self.beyond = pg.PlotCurveItem(connect="finite", antialias=True)
        self.curve = pg.PlotCurveItem(connect="finite", antialias=True)
        self._inside = np.zeros(len(DRAWN), bool)
        self._shown: object = None
        for depth, item in enumerate((self.bars, self.means, self.beyond, self.curve)):
            item.setZValue(10 + depth)
            plot.addItem(item)

    def remove(self) -> None:
        """Take the items off the plot."""
        for item in (self.bars, self.means, self.beyond, self.curve):
            self._plot.removeItem(item)

    def show(self, series: Series, colour: QColor, strong: bool) -> None:
        """Show a series; a strong one is that which the sliders move."""
        plot, means = self._plot, series.points.means
        mark = (series.points, series.number, colour.name(), strong)
        if mark == self._shown:
            self.show_shape(series.shape)
            return
        self._shown = mark
        heights = 2 * np.nan_to_num(means.sd)
        pen = plot.pen(colour, 1.2)
        self.bars.setData(x=means.angle, y=means.value, height=heights, pen=pen)
        self.means.setData(
            means.angle,
            means.value,
            size=(2.6 if strong else 2.2) * plot.dot_size(),
            symbol=series.symbol,
            brush=colour,
            pen=plot.pen(plot.palette().base().color(), 0.8),
        )
        self.curve.setPen(plot.pen(colour, 3.0 if strong else 1.8))
        self.beyond.setPen(plot.pen(colour, 1.5 if strong else 1.0, dashed=True))
        low, high = series.points.reach
        self._inside = (low - MARGIN <= DRAWN) & (high + MARGIN >= DRAWN)
        self.show_shape(series.shape)

    def show_shape(self, shape: Shape | None) -> tuple[Floats, Floats]:
        """Draw the curve: whole within the data, dashed beyond; give angles and values within."""
        if shape is None:
            self.curve.setData([], [])
            self.beyond.setData([], [])
            return np.zeros(0), np.zeros(0)
        y = shape.draw()
        inside = self._inside
        self.curve.setData(DRAWN, np.where(inside, y, np.nan))
        beyond = ~inside
        # The dashes begin where the whole line ends.
        beyond[1:] |= ~inside[:-1]
        beyond[:-1] |= ~inside[1:]
        self.beyond.setData(DRAWN, np.where(beyond, y, np.nan))
        return DRAWN[inside], y[inside]


class SeriesSample(pg.ItemSample):  # type: ignore[misc]
    """Line and symbol of a series in the legend."""

    def __init__(self, items: SeriesItems) -> None:
        super().__init__(items.means)
        self._items = items

    def paint(self, painter: QPainter, *_: Any) -> None:
        """Draw them over one another."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(pg.mkPen(self._items.curve.opts["pen"]))
        painter.drawLine(1, 10, 19, 10)
        opts = self._items.means.opts
        painter.translate(10, 10)
        size = min(float(opts["size"]), 11.0)
        drawSymbol(painter, opts["symbol"], size, pg.mkPen(opts["pen"]), pg.mkBrush(opts["brush"]))
