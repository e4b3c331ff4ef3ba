"""Ask a point for its values."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from PySide6.QtCore import Qt

from widgets.viewport.tools.navigate import Navigate
from widgets.viewport.tools.tool import Pointer, Surface

SLIP = 4.0  # pixels that a hand may move during a click


class Pick(Navigate):
    """A click picks, a drag still turns the picture.

    Parameters
    ----------
    view : Surface
    picked : callable
        Gets the place as shares of the view, y down.
    """

    name: ClassVar[str] = "pick"
    cursor: ClassVar[Qt.CursorShape] = Qt.CursorShape.PointingHandCursor

    def __init__(self, view: Surface, picked: Callable[[float, float], None]) -> None:
        super().__init__(view)
        self._picked = picked
        self._start: Pointer | None = None

    def press(self, at: Pointer) -> None:
        """Begin a click, or a drag."""
        self._start = at
        super().press(at)

    def move(self, at: Pointer) -> None:
        """Turn the picture once the hand moved too far for a click."""
        if self._start is not None:
            x, y = at.pixels_from(self._start)
            if max(abs(x), abs(y)) <= SLIP:
                return
            self._start = None
        super().move(at)

    def release(self, at: Pointer) -> None:
        """Pick, if it was a click."""
        start, self._start = self._start, None
        super().release(at)
        if start is not None:
            self._picked(start.x, start.y)
