"""Plots in the colours of the window: paper, ink and accent of the palette, axes with units."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import QEvent
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QWidget

MOST_DOTS = 20_000
LINES = 14
LEGEND_LINES = 1.6
ORANGE, GREEN = "#e69f00", "#009e73"


class Plot(pg.PlotWidget):  # type: ignore[misc]
    """A plot whose paper, ink and accent are those of the palette.

    Parameters
    ----------
    name : str
        For those who cannot see it, and for tests.
    x, y : str
        Titles of the axes with units, e.g. ``ω (°)``.
    box : ViewBox, optional
        One that takes the mouse in a way of its own.
    """

    _built = False

    def __init__(
        self,
        name: str,
        x: str,
        y: str,
        parent: QWidget | None = None,
        box: pg.ViewBox | None = None,
    ) -> None:
        super().__init__(parent, enableMenu=False, viewBox=box)
        self.setAccessibleName(name)
        self.setMinimumHeight(self.fontMetrics().height() * LINES)
        self.hideButtons()
        # A menu that nobody sees; with a parent it goes when the plot goes.
        menu = self.plotItem.ctrlMenu
        menu.setParent(self, menu.windowFlags())
        self.title_axis("bottom", x)
        self.title_axis("left", y)
        self._built = True
        self.restyle()

    @property
    def ink(self) -> QColor:
        """Colour of text and axes."""
        ink: QColor = self.palette().color(QPalette.ColorRole.Text)
        return ink

    @property
    def accent(self) -> QColor:
        """Colour of what matters most."""
        accent: QColor = self.palette().color(QPalette.ColorRole.Highlight)
        return accent

    def title_axis(self, side: str, title: str) -> None:
        """Name an axis; its numbers keep the unit of the title, without prefixes."""
        axis = self.getAxis(side)
        # No ranges first: switching off alone would keep the prefix of the moment.
        axis.setLabel(title, siPrefixEnableRanges=())
        axis.enableAutoSIPrefix(False)

    def restyle(self) -> None:
        """Take over the palette."""
        self.setBackground(self.palette().color(QPalette.ColorRole.Base))
        for side in ("bottom", "left"):
            style_axis(self.getAxis(side), self)

    def pen(self, colour: QColor | str, width: float = 2.0, dashed: bool = False) -> Any:
        """A line of that colour."""
        style = pg.QtCore.Qt.PenStyle.DashLine if dashed else pg.QtCore.Qt.PenStyle.SolidLine
        return pg.mkPen(colour, width=width, style=style)

    def add_legend_above(self, columns: int) -> pg.LegendItem:
        """A legend of one line in a row of its own above the data, which it never covers."""
        legend = pg.LegendItem(colCount=columns, labelTextSize="9pt")
        legend.layout.setContentsMargins(0, 0, 0, 0)
        legend.setParentItem(self.plotItem)
        legend.anchor((0.5, 0.0), (0.5, 0.0), offset=(0, 0))
        left, _, right, bottom = self.plotItem.layout.getContentsMargins()
        room = LEGEND_LINES * self.fontMetrics().height()
        self.plotItem.layout.setContentsMargins(left, room, right, bottom)
        return legend

    def dot_size(self) -> float:
        """Size of a dot that suits the font."""
        return float(self.fontMetrics().height()) / 5.0

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Follow the theme."""
        super().changeEvent(event)
        # The base class changes its palette while it is being built.
        if event.type() == QEvent.Type.PaletteChange and self._built:
            self.restyle()


def style_axis(axis: pg.AxisItem, plot: Plot) -> None:
    """Give an axis ink, line and font of a plot."""
    paper = plot.palette().color(QPalette.ColorRole.Base)
    axis.setPen(pg.mkPen(mix(plot.ink, paper)))
    axis.setTextPen(pg.mkPen(plot.ink))
    axis.setStyle(tickFont=plot.font())


def mix(first: QColor, second: QColor, share: float = 0.5) -> QColor:
    """A colour between two: `share` of the second."""
    pairs = (
        (first.redF(), second.redF()),
        (first.greenF(), second.greenF()),
        (first.blueF(), second.blueF()),
    )
    return QColor.fromRgbF(*(a + (b - a) * share for a, b in pairs))
