"""What the mouse does in the scan image when no contour is drawn: move, zoom and point."""

from __future__ import annotations

from typing import ClassVar, Protocol

from PySide6.QtCore import Qt

from widgets.viewport.tools.tool import Paper, Pointer, Tool

SLIP = 4.0  # pixels that a hand may move during a click
ZOOM_PER_NOTCH = 1.25


class Movable(Paper, Protocol):
    """What this tool may do to the view; places and ways in logical pixels."""

    def pan(self, x: float, y: float) -> None:
        """Move the picture."""

    def zoom(self, factor: float, x: float, y: float) -> None:
        """Make it larger; what is at the place stays there."""

    def fit(self) -> None:
        """Show all of it."""

    def click(self, x: float, y: float) -> None:
        """Ask for what is there."""


class Hand(Tool):
    """Drags the picture, zooms with the wheel, fits with a double click; a click points."""

    name: ClassVar[str] = "navigate"

    def __init__(self, view: Movable) -> None:
        self._view = view
        self._start: Pointer | None = None
        self._last: Pointer | None = None

    def press(self, at: Pointer) -> None:
        """Begin a click, or a drag."""
        self._start = at if at.button == Qt.MouseButton.LeftButton else None
        self._last = at

    def move(self, at: Pointer) -> None:
        """Follow the hand once it moved too far for a click."""
        if self._last is None:
            return
        x, y = at.pixels_from(self._last)
        if self._start is not None and max(abs(x), abs(y)) <= SLIP:
            return
        self._start, self._last = None, at
        self._view.pan(x, y)

    def release(self, at: Pointer) -> None:
        """Let go; point, if it was a click."""
        start, self._start, self._last = self._start, None, None
        if start is not None:
            self._view.click(start.x * start.width, start.y * start.height)

    def double_click(self, at: Pointer) -> None:
        """Show all."""
        self._view.fit()

    def turn_wheel(self, at: Pointer, notches: float) -> None:
        """Zoom; what is under the cursor stays there."""
        self._view.zoom(ZOOM_PER_NOTCH**notches, at.x * at.width, at.y * at.height)

    def cancel(self) -> bool:
        """Let go of the picture."""
        held, self._start, self._last = self._last is not None, None, None
        return held


class PointingHand(Hand):
    """The same with a cursor that says so, when the tool for picking is armed."""

    name: ClassVar[str] = "pick"
    cursor: ClassVar[Qt.CursorShape] = Qt.CursorShape.PointingHandCursor
