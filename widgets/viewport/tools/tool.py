"""What a mouse tool is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter

from app.render.camera import Camera


@dataclass(frozen=True, slots=True)
class Pointer:
    """Where the mouse is and what is held.

    Attributes
    ----------
    x, y : float
        Shares of the view's width and height, y down.
    width, height : int
        Size of the view in logical pixels.
    button : Qt.MouseButton
        What was pressed or released; NoButton for a move.
    modifiers : Qt.KeyboardModifier
    """

    x: float
    y: float
    width: int
    height: int
    button: Qt.MouseButton = Qt.MouseButton.NoButton
    modifiers: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier

    def pixels_from(self, other: Pointer) -> tuple[float, float]:
        """How far this is from another place, in logical pixels."""
        return (self.x - other.x) * self.width, (self.y - other.y) * self.height


class Paper(Protocol):
    """What a tool that draws may do to the view."""

    def refresh_overlay(self) -> None:
        """Paint what lies over the picture again."""


class Surface(Paper, Protocol):
    """What a tool may do to the view."""

    def camera(self) -> Camera:
        """Where the viewer stands."""

    def move_camera(self, camera: Camera) -> None:
        """Look from elsewhere; more movement is likely to follow."""

    def centre_at(self, x: float, y: float) -> bool:
        """Turn around what is drawn there from now on."""


class Tool:
    """A mouse tool; each gesture it does not know does nothing."""

    name: ClassVar[str] = ""
    cursor: ClassVar[Qt.CursorShape] = Qt.CursorShape.ArrowCursor

    def press(self, at: Pointer) -> None:
        """A button went down."""

    def move(self, at: Pointer) -> None:
        """The mouse moved with a button held."""

    def release(self, at: Pointer) -> None:
        """The button came up."""

    def double_click(self, at: Pointer) -> None:
        """A button went down twice."""

    def turn_wheel(self, at: Pointer, notches: float) -> None:
        """The wheel turned, away from the hand when `notches` is positive."""

    def cancel(self) -> bool:
        """Give up what is half done; tells whether there was something."""
        return False

    def paint(self, painter: QPainter, width: int, height: int) -> None:
        """Draw over the picture, in logical pixels."""
