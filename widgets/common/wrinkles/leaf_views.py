"""A leaf as the scanner saw it and from its side, in Δω or in Δω over its error."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QTabBar, QVBoxLayout, QWidget

from app.core.arrays import Floats
from app.core.units import to_degrees
from app.core.wrinkles import SIGN_OF_DELTA
from app.core.wrinkling.leaf import JudgedLeaf
from app.render.palettes import MISSING
from app.services.wrinkles.measure import LeafWrinkles
from app.services.wrinkles.picture import (
    choose_framed,
    find_limit,
    line_of_plane,
    see_from_scanner,
    see_from_side,
)
from widgets.common.colour_strip import ColourStrip
from widgets.common.numbers import show_number, show_signed
from widgets.common.plots import Plot
from widgets.common.wrinkles.rasters import PALETTE, Raster, find_spacing, paint, rasterise
from widgets.common.wrinkles.words import tell_reasons

Shown = Literal["delta", "significance"]
LINES = 12
LEAST_SIGMAS, MOST_SIGMAS = 3.0, 12.0


class LeafPlot(Plot):
    """Cells of a leaf over millimetres, and a line through them."""

    _cells: tuple[Raster, float] | None = None

    def __init__(self, name: str, x: str, y: str, parent: QWidget | None = None) -> None:
        super().__init__(name, x, y, parent)
        self.image = pg.ImageItem(axisOrder="row-major")
        self.line = pg.PlotDataItem()
        self.addItem(self.image)
        self.addItem(self.line)
        self.setAspectLocked(True)
        self.setMinimumHeight(self.fontMetrics().height() * LINES)
        self.setMinimumWidth(self.fontMetrics().height() * 9)

    def show_cells(self, raster: Raster, limit: float) -> None:
        """Show cells; colours end at ±`limit`."""
        self._cells = (raster, limit)
        self._paint()
        square = QRectF(raster.left, raster.low, raster.side, raster.side)
        self.image.setRect(square)
        self.setRange(square, padding=0.0)

    def restyle(self) -> None:
        """Take over the palette: ink, and the grey of what is not valid."""
        super().restyle()
        self._paint()

    def _paint(self) -> None:
        if self._cells is not None:
            dark = self.palette().color(QPalette.ColorRole.Base).lightnessF() < 0.5
            grey = MISSING["dark" if dark else "light"]
            self.image.setImage(paint(*self._cells, grey), levels=(0, 255))
            self.line.setPen(self.pen(self.ink, 1.2))


class LeafViews(QWidget):
    """Both views, what their colours mean, and why points are grey."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.found: LeafWrinkles | None = None
        self.limit = 0.0
        self.tabs = QTabBar(self)
        self.scanner = LeafPlot(
            self.tr("The leaf as the scanner saw it"), self.tr("mm to the right"),
            self.tr("mm up"), self,
        )  # fmt: skip
        self.side = LeafPlot(
            self.tr("The leaf from its side, with its plane"), self.tr("mm along the beam"),
            self.tr("mm along the tilt"), self,
        )  # fmt: skip
        self.strip = ColourStrip(PALETTE, self)
        self.legend = QLabel(SIGN_OF_DELTA, self)
        self.reasons = QLabel(self)
        self._fill()
        self._lay_out()
        self.tabs.currentChanged.connect(self._draw)

    @property
    def shown(self) -> Shown:
        """Which of the two quantities is seen."""
        found: Shown = self.tabs.tabData(self.tabs.currentIndex())
        return found

    def show_leaf(self, found: LeafWrinkles) -> None:
        """Show a leaf that was judged."""
        self.found = found
        self._draw()

    def _draw(self, _: int = 0) -> None:
        found = self.found
        judged = None if found is None else found.judged
        if found is None or judged is None:
            return
        valid, framed = judged.angles.valid, choose_framed(found.measured, judged)
        values = self._take_values(judged)
        x, y = see_from_scanner(found.measured)
        spacing = find_spacing(x, y)
        self.scanner.show_cells(rasterise(x, y, values, valid, framed, spacing), self.limit)
        x, y = see_from_side(found.measured, judged)
        self.side.show_cells(rasterise(x, y, values, valid, framed, spacing), self.limit)
        self.side.line.setData(*line_of_plane(found.measured, judged))
        self._name_colours()
        self.reasons.setText(tell_reasons(judged))

    def _take_values(self, judged: JudgedLeaf) -> Floats:
        """What is shown, and where its colours end."""
        if self.shown == "delta":
            self.limit = find_limit([judged]) if judged.angles.valid.any() else LEAST_SIGMAS
            return np.asarray(to_degrees(judged.delta))
        strong = np.abs(judged.significance[judged.angles.valid])
        strong = strong[np.isfinite(strong)]
        reach = float(np.ceil(np.quantile(strong, 0.98))) if len(strong) else 0.0
        self.limit = float(np.clip(reach, LEAST_SIGMAS, MOST_SIGMAS))
        return np.asarray(np.clip(judged.significance, -MOST_SIGMAS, MOST_SIGMAS))

    def _name_colours(self) -> None:
        unit = "°" if self.shown == "delta" else " σ"
        low, high = show_number(-self.limit, 0), show_signed(self.limit, 0)
        self.strip.show_texts(
            self.tr("{0} face-on").format(low + unit),
            self.tr("0 on the plane"),
            self.tr("edge-on {0}").format(high + unit),
        )

    def _fill(self) -> None:
        for title, data, tip in (
            ("Δω", "delta", self.tr("Angle from intensity less the plane's angle, degrees")),
            ("Δω / σ", "significance",
             self.tr("The same over its own error: beyond ±2 it is hardly noise")),
        ):  # fmt: skip
            tab = self.tabs.addTab(title)
            self.tabs.setTabData(tab, data)
            self.tabs.setTabToolTip(tab, tip)
        self.tabs.setAccessibleName(self.tr("What the colours show"))
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        for label in (self.legend, self.reasons):
            label.setWordWrap(True)
        self.legend.setProperty("faint", "true")

    def _lay_out(self) -> None:
        views = QGridLayout()
        views.setColumnStretch(0, 1)
        views.setColumnStretch(1, 1)
        for column, (title, plot) in enumerate(
            ((self.tr("From the scanner"), self.scanner), (self.tr("From the side"), self.side))
        ):
            views.addWidget(QLabel(title, self), 0, column)
            views.addWidget(plot, 1, column)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.tabs)
        layout.addLayout(views)
        for part in (self.strip, self.legend, self.reasons):
            layout.addWidget(part)
