"""Draw around points with a free hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from widgets.viewport.tools.tool import Paper, Pointer, Tool

Combine = Literal["replace", "add", "subtract"]
Corner = tuple[float, float]
STEP = 2.0  # pixels between corners
SUBTRACTING = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier
LINES: dict[Combine, QColor] = {
    "replace": QColor(236, 0, 140),
    "add": QColor(0, 158, 115),
    "subtract": QColor(213, 94, 0),
}


class Lasso(Tool):
    """Freehand lasso: Shift adds, Ctrl or Alt takes away, Esc gives up; stays armed.

    Nothing is rendered while it is drawn: the canvas shows its last frame again.

    Parameters
    ----------
    view : Paper
    finished : callable
        Gets the corners as shares of the view (y down) and how to combine.
    """

    name: ClassVar[str] = "lasso"
    cursor: ClassVar[Qt.CursorShape] = Qt.CursorShape.CrossCursor

    def __init__(self, view: Paper, finished: Callable[[list[Corner], Combine], None]) -> None:
        self._view = view
        self._finished = finished
        self._corners: list[Corner] = []
        self._last: Pointer | None = None
        self._combine: Combine = "replace"

    def press(self, at: Pointer) -> None:
        """Begin a contour."""
        self._combine = _combine(at.modifiers)
        self._corners = [(at.x, at.y)]
        self._last = at
        self._view.refresh_overlay()

    def move(self, at: Pointer) -> None:
        """Follow the hand."""
        if self._last is None:
            return
        x, y = at.pixels_from(self._last)
        if abs(x) + abs(y) >= STEP:
            self._corners.append((at.x, at.y))
            self._last = at
            self._view.refresh_overlay()

    def release(self, at: Pointer) -> None:
        """Close the contour; fewer than three corners are a slip of the hand."""
        if self._last is None:
            return
        self.move(at)
        corners, combine = self._corners, self._combine
        self.cancel()
        if len(corners) >= 3:
            self._finished(corners, combine)

    def cancel(self) -> bool:
        """Forget the contour."""
        begun = self._last is not None
        self._corners, self._last = [], None
        self._view.refresh_overlay()
        return begun

    def paint(self, painter: QPainter, width: int, height: int) -> None:
        """Draw the contour so far, with its closing line."""
        if len(self._corners) < 2:
            return
        line = QPolygonF([QPointF(x * width, y * height) for x, y in self._corners])
        colour = LINES[self._combine]
        fill = QColor(colour)
        fill.setAlpha(36)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(fill)
        painter.drawPolygon(line, Qt.FillRule.WindingFill)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        # A pale line below keeps the contour visible on every colour.
        painter.setPen(QPen(QColor(255, 255, 255, 170), 4))
        painter.drawPolyline(line)
        painter.setPen(QPen(colour, 2))
        painter.drawPolyline(line)
        painter.setPen(QPen(colour, 1, Qt.PenStyle.DashLine))
        painter.drawLine(line.last(), line.first())


def _combine(modifiers: Qt.KeyboardModifier) -> Combine:
    if modifiers & SUBTRACTING:
        return "subtract"
    return "add" if modifiers & Qt.KeyboardModifier.ShiftModifier else "replace"
