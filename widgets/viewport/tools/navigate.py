"""Turn, move and zoom with the mouse."""

from __future__ import annotations

import math
from typing import ClassVar

from PySide6.QtCore import Qt

from app.render.camera import pan, turn, zoom
from widgets.viewport.tools.tool import Pointer, Surface, Tool

# A drag over the height of the view turns by half a circle.
TURN = math.pi
ZOOM_PER_NOTCH = 1.2
PAN_BUTTONS = (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton)


class Navigate(Tool):
    """Left turns; middle, right or Shift with left moves; double click sets the centre."""

    name: ClassVar[str] = "navigate"
    cursor: ClassVar[Qt.CursorShape] = Qt.CursorShape.ArrowCursor

    def __init__(self, view: Surface) -> None:
        self._view = view
        self._last: Pointer | None = None
        self._panning = False

    def press(self, at: Pointer) -> None:
        """Begin to turn or to move."""
        shift = bool(at.modifiers & Qt.KeyboardModifier.ShiftModifier)
        self._panning = at.button in PAN_BUTTONS or shift
        self._last = at

    def move(self, at: Pointer) -> None:
        """Follow the hand."""
        if self._last is None:
            return
        x, y = at.pixels_from(self._last)
        right, up = x / at.height, -y / at.height
        camera = self._view.camera()
        if self._panning:
            self._view.move_camera(pan(camera, right, up))
        else:
            self._view.move_camera(turn(camera, TURN * right, TURN * up))
        self._last = at

    def release(self, at: Pointer) -> None:
        """Let go."""
        self._last = None

    def double_click(self, at: Pointer) -> None:
        """Turn around the point under the cursor from now on."""
        self._view.centre_at(at.x, at.y)

    def cancel(self) -> bool:
        """Let go of the picture."""
        held, self._last = self._last is not None, None
        return held

    def turn_wheel(self, at: Pointer, notches: float) -> None:
        """Zoom; what is under the cursor stays there."""
        aspect = at.width / at.height
        right, up = (at.x - 0.5) * aspect, 0.5 - at.y
        factor = ZOOM_PER_NOTCH**notches
        self._view.move_camera(zoom(self._view.camera(), factor, right, up))
