"""Plots in the colours of the window: axes with units, a curve, points or their density."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QRectF
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QWidget

from app.core.arrays import AnyArray, Floats
from app.render.palettes import colour_table

MOST_DOTS = 20_000
LINES = 14
ORANGE, GREEN = "#e69f00", "#009e73"


class Plot(pg.PlotWidget):  # type: ignore[misc]
    """A plot whose paper, ink and accent are those of the palette.

    Parameters
    ----------
    name : str
        For those who cannot see it, and for tests.
    x, y : str
        Titles of the axes with units, e.g. ``ω (°)``.
    """

    _built = False

    def __init__(self, name: str, x: str, y: str, parent: QWidget | None = None) -> None:
        super().__init__(parent, enableMenu=False)
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
            axis = self.getAxis(side)
            axis.setPen(pg.mkPen(mix(self.ink, self.palette().color(QPalette.ColorRole.Base))))
            axis.setTextPen(pg.mkPen(self.ink))
            axis.setStyle(tickFont=self.font())

    def pen(self, colour: QColor | str, width: float = 2.0, dashed: bool = False) -> Any:
        """A line of that colour."""
        style = pg.QtCore.Qt.PenStyle.DashLine if dashed else pg.QtCore.Qt.PenStyle.SolidLine
        return pg.mkPen(colour, width=width, style=style)

    def dot_size(self) -> float:
        """Size of a dot that suits the font."""
        return float(self.fontMetrics().height()) / 5.0

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Follow the theme."""
        super().changeEvent(event)
        # The base class changes its palette while it is being built.
        if event.type() == QEvent.Type.PaletteChange and self._built:
            self.restyle()


def mix(first: QColor, second: QColor, share: float = 0.5) -> QColor:
    """A colour between two: `share` of the second."""
    pairs = (
        (first.redF(), second.redF()),
        (first.greenF(), second.greenF()),
        (first.blueF(), second.blueF()),
    )
    return QColor.fromRgbF(*(a + (b - a) * share for a, b in pairs))


class DensityImage(pg.ImageItem):  # type: ignore[misc]
    """Where there are too many points to draw: how many fall in each small rectangle."""

    def __init__(self, palette: str = "viridis") -> None:
        super().__init__(axisOrder="row-major")
        self._table = colour_table(palette)

    def show_counts(self, counts: AnyArray, x: Floats, y: Floats) -> None:
        """Show (rows, columns) counts between the edges `x` and `y`, on a log scale."""
        level = np.log1p(counts) / max(float(np.log1p(counts.max())), 1e-12)
        rgba = self._table[(level * 255.0).astype(np.int64)].copy()
        rgba[counts == 0, 3] = 0
        self.setImage(rgba, levels=(0, 255))
        self.setRect(QRectF(x[0], y[0], x[-1] - x[0], y[-1] - y[0]))
