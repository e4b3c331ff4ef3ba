"""Plot of intensity against incidence angle: points or their density, means, curves, brush."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from app.core.arrays import Bools
from app.render.overlay import SELECTED_COLOUR
from widgets.common.lab.brush import BrushBox
from widgets.common.lab.density import InkDensity
from widgets.common.lab.residual_strip import ResidualStrip
from widgets.common.lab.series import Series, Shape, fit_to_paper
from widgets.common.lab.series_items import SeriesItems, SeriesSample
from widgets.common.plots import Plot, mix

LEGEND_LINE = 1.25
"""Height of a line of the legend in heights of the font."""
MOST_HEADROOM = 0.45
TICKS = range(0, 91, 15)
LINES, AXIS, STRETCH = 9, 4.2, 3
ROOM_FOR_STRIP, ROOM_FOR_LEGEND = 16, 12
"""Heights in heights of the font below which these leave their room to the curve."""
ANY_HEIGHT = 16_777_215.0
OWN_KEYS = (Qt.Key.Key_Escape, Qt.Key.Key_Home)
NARROW = 30
"""Letters that a line of the legend may have in a narrow panel."""
NOTHING = Series("")


class AngularPlot(Plot):
    """The first series has its points drawn and its curve moved; the others lie over it.

    Signals
    -------
    cleared()
        Escape or a double click: nothing shall be selected.
    """

    cleared = Signal()

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        self.box = BrushBox()
        super().__init__(name, "ω (°)", "", parent, self.box)
        self._series: tuple[Series, ...] = ()
        self._lit: Bools | None = None
        self._shape: Shape | None = None
        self._drawn: object = None
        self._named: object = None
        self._dots, self._lit_dots = pg.ScatterPlotItem(pen=None), pg.ScatterPlotItem(pen=None)
        self._density, self._lit_density = InkDensity(), InkDensity()
        self._low, self._high = pg.PlotDataItem(), pg.PlotDataItem()
        self._band = pg.FillBetweenItem(self._low, self._high)
        for item in (
            self._density, self._dots, self._lit_density, self._lit_dots, self._band,
        ):  # fmt: skip
            self.addItem(item)
        self._items: list[SeriesItems] = [SeriesItems(self)]
        self._legend = self.addLegend(offset=(-4, 4), verSpacing=-4, colCount=1)
        self._range: tuple[float, float, int] | None = None
        self._fitted = (0.0, 1.0)
        self._strip_wanted = True
        self.strip = ResidualStrip(self, self.tr("Residual"))
        self._rows = pg.GraphicsLayout()
        self._stack()
        self.getAxis("bottom").setTicks([[(angle, f"{angle}") for angle in TICKS]])
        self.setXRange(0.0, 90.0, padding=0.03)

    @property
    def curve(self) -> pg.PlotCurveItem:
        """The curve that the sliders move."""
        return self._items[0].curve

    @property
    def means(self) -> pg.ScatterPlotItem:
        """The means of the points that it belongs to."""
        return self._items[0].means

    @property
    def items_of_series(self) -> tuple[SeriesItems, ...]:
        """What is drawn of each series."""
        return tuple(self._items)

    def colour_of(self, series: Series) -> QColor:
        """Colour of a series on the paper of the theme."""
        return fit_to_paper(series.colour, self.palette().base().color())

    def show_strip(self, wanted: bool) -> None:
        """Show the residuals below the plot, or not; in a low plot they have no room."""
        self._strip_wanted = wanted
        self._make_room_for_strip()

    def _make_room_for_strip(self) -> None:
        lines = self.height() / self._em
        # A legend of two lines would cover the points of a low plot.
        self._legend.setVisible(lines >= ROOM_FOR_LEGEND or len(self._series) > 1)
        shown = self._strip_wanted and lines >= ROOM_FOR_STRIP
        if shown == self.strip.isVisible():
            return
        self.strip.setVisible(shown)
        # A hidden row keeps its height otherwise.
        self._rows.layout.setRowMaximumHeight(1, ANY_HEIGHT if shown else 0.0)
        if shown:
            self.strip.show_series(self._series)
            self.strip.move_curve(self._shape)

    def show_series(self, series: Sequence[Series]) -> None:
        """Show series; the first is the one at work."""
        self._series = tuple(series) or (NOTHING,)
        while len(self._items) > len(self._series):
            self._items.pop().remove()
        while len(self._items) < len(self._series):
            self._items.append(SeriesItems(self))
        for items, one in zip(self._items, self._series, strict=True):
            items.show(one, self.colour_of(one), strong=items is self._items[0])
        self._draw_points()
        self._make_room_for_strip()
        self._fit_height()
        if self.strip.isVisible():
            self.strip.show_series(self._series)
        self.move_curve(self._series[0].shape)
        self.light_up(self._lit)

    def move_curve(self, shape: Shape | None) -> None:
        """Draw another curve for the first series, and nothing else."""
        self._shape = shape
        if self.strip.isVisible():
            self.strip.move_curve(shape)
        x, y = self._items[0].show_shape(shape)
        scatter = None if shape is None else shape.scatter
        shown = scatter is not None and len(x) > 0
        self._band.setVisible(shown)
        self._name_items()
        if scatter is not None and shown:
            self._low.setData(x, y - scatter)
            self._high.setData(x, y + scatter)

    def light_up(self, lit: Bools | None) -> None:
        """Show which points of the first series are selected; None: no point."""
        points = self._series[0].points if self._series else NOTHING.points
        self._lit = lit if lit is not None and len(lit) == points.count and lit.any() else None
        dense = points.density is not None
        self._lit_dots.setVisible(self._lit is not None and not dense)
        self._lit_density.setVisible(self._lit is not None and dense)
        if self._lit is None:
            return
        colour = QColor(*SELECTED_COLOUR[:3])
        if points.density is None:
            self._lit_dots.setData(
                points.angle[self._lit],
                points.value[self._lit],
                size=1.15 * self.dot_size(),
                brush=colour,
                pen=None,
            )
        else:
            counts = points.cells.count(points.angle[self._lit], points.value[self._lit])
            most = float(points.density.max())
            self._lit_density.show_counts(counts, points.cells, colour, most)

    def show_all(self) -> None:
        """Go back to all points and 0° to 90°."""
        self._range = None
        self.setXRange(0.0, 90.0, padding=0.03)
        self._fit_height()

    def restyle(self) -> None:
        """Draw in the colours of the palette."""
        super().restyle()
        if self._built and getattr(self, "_rows", None) is not None:
            self.strip.restyle()
            self.show_series(self._series)

    @property
    def _em(self) -> int:
        return int(self.fontMetrics().height())

    def sizeHint(self) -> QSize:  # noqa: N802
        """Low: it takes what others leave. The picture's own hint would keep what it once had."""
        return QSize(24 * self._em, self.minimumHeight())

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Leave the residuals out where there is no room."""
        super().resizeEvent(event)
        if self._built and getattr(self, "_rows", None) is not None:
            self._make_room_for_strip()
            if np.allclose(self.viewRange()[1], self._fitted, rtol=1e-6):  # not zoomed meanwhile
                self._range = None
                self._fit_height()

    def event(self, event: QEvent) -> bool:
        """Keep the keys that mean something here from the window's shortcuts."""
        if event.type() == QEvent.Type.ShortcutOverride and event.key() in OWN_KEYS:  # type: ignore[attr-defined]
            event.accept()
            return True
        return bool(super().event(event))

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Escape selects nothing, Home shows all."""
        if event.key() == Qt.Key.Key_Escape:
            self.cleared.emit()
        elif event.key() == Qt.Key.Key_Home:
            self.show_all()
        else:
            super().keyPressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Select nothing."""
        super().mouseDoubleClickEvent(event)
        if event.button() == Qt.MouseButton.LeftButton:
            self.cleared.emit()

    def _stack(self) -> None:
        """Put the plot above the strip, in one picture, angles above one another."""
        self.setCentralItem(self._rows)
        self._rows.addItem(self.plotItem, 0, 0)
        self._rows.addItem(self.strip, 1, 0)
        self._rows.layout.setRowStretchFactor(0, STRETCH)
        self._rows.layout.setRowStretchFactor(1, 1)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(0)
        self.setMinimumHeight(self.fontMetrics().height() * LINES)
        for axis in (self.getAxis("left"), self.strip.getAxis("left")):
            axis.setWidth(AXIS * self.fontMetrics().height())
        self.strip.restyle()

    def _draw_points(self) -> None:
        """Draw the points; those that are drawn already stay, since most changes are of curves."""
        points, ink = self._series[0].points, self.ink
        band = self.colour_of(self._series[0])
        band.setAlphaF(0.2)
        self._band.setBrush(band)
        self._name_items()
        mark = (points, ink.name())
        if mark == self._drawn:
            return
        self._drawn = mark
        dots = points.dots
        faint = mix(ink, self.palette().base().color(), 0.35)
        faint.setAlphaF(0.35 if points.count > 2000 else 0.55)
        x, y = dots if dots is not None else (np.zeros(0), np.zeros(0))
        self._dots.setData(x, y, size=self.dot_size(), brush=faint, pen=None)
        self._density.setVisible(points.density is not None)
        if points.density is not None:
            self._density.show_counts(points.density, points.cells, ink)
        self.box.colour_brush(QColor(*SELECTED_COLOUR[:3]))

    def _fit_height(self) -> None:
        """Make room for all series and the legend, unless the user has zoomed meanwhile."""
        filled = [s.points for s in self._series if s.points.count]
        bottom = min((p.bottom for p in filled), default=0.0)
        top = max((p.top for p in filled), default=1.0)
        wanted = (bottom, top, len(self._series) if self._legend.isVisible() else 0)
        if wanted == self._range:
            return
        self._range = wanted
        lines = max(len(self._series), 2) if self._legend.isVisible() else 0
        line = LEGEND_LINE * self.fontMetrics().height()
        share = min((lines + 0.5) * line / max(self.box.height(), line), MOST_HEADROOM)
        height = max(top - bottom, 1e-12) / (1.0 - share)
        self._fitted = bottom, bottom + height
        self.setYRange(*self._fitted, padding=0.0)

    def _name_items(self) -> None:
        fitted = self._shape is None or self._shape.scatter is not None
        names = (fitted, self.ink.name(), [(s.title, s.number) for s in self._series])
        if names == self._named:
            return
        self._named = names
        self._legend.clear()
        self._legend.setLabelTextColor(self.ink)
        ground = QColor(self.palette().base().color())
        ground.setAlphaF(0.8)
        self._legend.setBrush(ground)
        if len(self._series) <= 1:
            self._legend.setColumnCount(1)
            curve = self.tr("curve ± RMSE") if fitted else self.tr("curve, not fitted")
            self._legend.addItem(self.curve, curve)
            self._legend.addItem(self.means, self.tr("mean ± sd per 5°"))
            return
        longest = max(len(series.title) for series in self._series)
        columns = min(max(NARROW // max(longest, 1), 1), len(self._series))
        self._legend.setColumnCount(columns)
        for items, series in zip(self._items, self._series, strict=False):
            # The legend closes what it drops: a sample lives only once.
            self._legend.addItem(SeriesSample(items), series.title)
