"""The brush of the plot: angles, intensities or a rectangle, drawn with the left button."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QGraphicsRectItem

from app.core.arrays import Bools, Floats

BrushKind = Literal["angles", "values", "both"]
Combine = Literal["replace", "add", "subtract"]
Button = Qt.MouseButton


@dataclass(frozen=True, slots=True)
class Brush:
    """Closed limits of angle (degrees) and intensity; infinite where there is none."""

    angles: tuple[float, float] = (-math.inf, math.inf)
    values: tuple[float, float] = (-math.inf, math.inf)
    combine: Combine = "replace"

    def covers(self, angle: Floats, value: Floats) -> Bools:
        """Which points lie within."""
        inside: Bools = np.ones(len(angle), bool)
        for numbers, (low, high) in ((angle, self.angles), (value, self.values)):
            if math.isfinite(low):
                inside &= (numbers >= low) & (numbers <= high)
        return inside


class BrushBox(pg.ViewBox):  # type: ignore[misc]
    """The area of a plot: with a brush in hand the left button selects, else it moves the plot.

    The wheel zooms at the cursor, over an axis along it alone; the right and the middle button
    move the plot whatever is in hand.

    Signals
    -------
    brushed(Brush, bool)
        Limits while the mouse is dragged; True when it is let go.
    """

    brushed = Signal(object, bool)

    def __init__(self) -> None:
        super().__init__(enableMenu=False)
        self.kind: BrushKind | None = None
        self._bands = {
            "angles": pg.LinearRegionItem(movable=False),
            "values": pg.LinearRegionItem(movable=False, orientation="horizontal"),
        }
        self._frame = QGraphicsRectItem()
        for item in (*self._bands.values(), self._frame):
            item.setZValue(20)
            self.addItem(item, ignoreBounds=True)
        self.hide_brush()

    def arm(self, kind: BrushKind | None) -> None:
        """Take a brush in hand, or none."""
        self.kind = kind
        self.setCursor(Qt.CursorShape.ArrowCursor if kind is None else Qt.CursorShape.CrossCursor)

    def colour_brush(self, colour: QColor) -> None:
        """Choose the colour of the marked range."""
        ground = QColor(colour)
        ground.setAlphaF(0.12)
        pen = pg.mkPen(colour, width=1)
        for band in self._bands.values():
            band.setBrush(ground)
            for line in band.lines:
                line.setPen(pen)
        self._frame.setPen(pen)
        self._frame.setBrush(ground)

    def hide_brush(self) -> None:
        """Take the marked range off the plot."""
        for item in (*self._bands.values(), self._frame):
            item.hide()

    def mouseDragEvent(self, ev: Any, axis: int | None = None) -> None:  # noqa: N802
        """Brush with the left button, move the plot with the others."""
        if ev.button() == Button.LeftButton and self.kind is not None and axis is None:
            ev.accept()
            brush = self._read(ev, self.kind)
            self._show(brush)
            self.brushed.emit(brush, ev.isFinish())
        elif ev.button() == Button.RightButton and axis is None:
            ev.accept()
            self._pan(ev)
        else:
            super().mouseDragEvent(ev, axis)

    def _pan(self, ev: Any) -> None:
        before, now = self.mapToView(ev.lastPos()), self.mapToView(ev.pos())
        self.translateBy(x=before.x() - now.x(), y=before.y() - now.y())
        self.sigRangeChangedManually.emit(self.state["mouseEnabled"])

    def _read(self, ev: Any, kind: BrushKind) -> Brush:
        start, stop = self.mapToView(ev.buttonDownPos()), self.mapToView(ev.pos())
        angles = (min(start.x(), stop.x()), max(start.x(), stop.x()))
        values = (min(start.y(), stop.y()), max(start.y(), stop.y()))
        keys, combine = ev.modifiers(), "replace"
        if keys & Qt.KeyboardModifier.ShiftModifier:
            combine = "add"
        elif keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier):
            combine = "subtract"
        everything = Brush()
        return Brush(
            everything.angles if kind == "values" else angles,
            everything.values if kind == "angles" else values,
            combine,  # type: ignore[arg-type]
        )

    def _show(self, brush: Brush) -> None:
        self.hide_brush()
        (left, right), (low, high) = brush.angles, brush.values
        if math.isfinite(left) and math.isfinite(low):
            self._frame.setRect(QRectF(left, low, right - left, high - low))
            self._frame.show()
            return
        name, region = ("angles", (left, right)) if math.isfinite(left) else ("values", (low, high))
        self._bands[name].setRegion(region)
        self._bands[name].show()
