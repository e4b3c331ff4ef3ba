"""Strip below the plot: what the means leave over from the curve."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg

from app.core.arrays import Floats
from widgets.common.lab.series import Series, Shape, fit_to_paper
from widgets.common.plots import Plot, style_axis

ROOM, STRIDE = 1.25, 1.6
ASIDE = 0.9
"""Degrees between the means of two series, which all lie about zero."""


class ResidualStrip(pg.PlotItem):  # type: ignore[misc]
    """Mean of the values of each step less the curve there, a symbol per series.

    It lies in the picture of the plot above: what is painted together is painted once.
    """

    def __init__(self, plot: Plot, title: str) -> None:
        super().__init__(enableMenu=False)
        self._plot = plot
        menu = self.ctrlMenu
        menu.setParent(plot, menu.windowFlags())  # with a parent it goes when the plot goes
        self._series: tuple[Series, ...] = ()
        self._items: list[tuple[pg.PlotCurveItem, pg.ScatterPlotItem]] = []
        self._reach = 0.0
        self.hideButtons()
        self.setMouseEnabled(x=False, y=False)
        self.setXLink(plot.plotItem)
        self.setLabel("left", title)
        self.getAxis("left").enableAutoSIPrefix(False)
        self.getAxis("bottom").setStyle(showValues=False)
        self.zero = pg.InfiniteLine(0.0, angle=0)
        self.addItem(self.zero)
        self.setToolTip(
            plot.tr(
                "Mean of each step of the angle less the curve there; the bar is the standard "
                "error of the mean. A good curve leaves no pattern."
            )
        )

    @property
    def residuals(self) -> Floats:
        """Those of the first series."""
        found: Floats = self._items[0][1].getData()[1] if self._items else np.zeros(0)
        return found

    def show_series(self, series: Sequence[Series]) -> None:
        """Show what is left of all series; those without a curve have nothing to leave."""
        self._series = tuple(series)
        while len(self._items) > len(self._series):
            for item in self._items.pop():
                self.removeItem(item)
        while len(self._items) < len(self._series):
            # Not an item for error bars: that one asks for a second painting after each.
            pair = pg.PlotCurveItem(connect="pairs"), pg.ScatterPlotItem()
            self._items.append(pair)
            for item in pair:
                self.addItem(item)
        self._reach = 0.0
        for number, one in enumerate(self._series):
            self._show(number, one, one.shape)

    def move_curve(self, shape: Shape | None) -> None:
        """Show what another curve leaves of the first series."""
        if self._series:
            self._show(0, self._series[0], shape)

    def restyle(self) -> None:
        """Draw in the colours of the palette."""
        for side in ("bottom", "left"):
            style_axis(self.getAxis(side), self._plot)
        self.zero.setPen(self._plot.pen(self._plot.ink, 1.0))

    def _show(self, number: int, series: Series, shape: Shape | None) -> None:
        bars, dots = self._items[number]
        means = series.points.means
        left = means.value - shape.draw(means.angle) if shape is not None else np.zeros(0)
        known = np.isfinite(left)
        aside = ASIDE * (number - (len(self._series) - 1) / 2)
        x, y = means.angle[: len(left)][known] + aside, left[known]
        error = np.nan_to_num(means.error[: len(left)][known])
        paper = self._plot.palette().base().color()
        colour = fit_to_paper(series.colour, paper)
        bars.setData(np.repeat(x, 2), np.column_stack((y - error, y + error)).ravel())
        bars.setPen(self._plot.pen(colour, 1.2))
        dots.setData(
            x,
            y,
            size=(2.2 if number == 0 else 1.9) * self._plot.dot_size(),
            symbol=series.symbol,
            brush=colour,
            pen=self._plot.pen(paper, 0.8),
        )
        self._grow(float(np.max(np.abs(y) + error, initial=0.0)))

    def _grow(self, reach: float) -> None:
        """Make room; while a slider moves, the scale only grows, and by large steps.

        A scale that follows each move would jitter, and cost more than the whole plot.
        """
        if reach > self._reach:
            self._reach = reach * (STRIDE if self._reach > 0.0 else 1.0)
            self.setYRange(-ROOM * self._reach, ROOM * self._reach, padding=0.0)
