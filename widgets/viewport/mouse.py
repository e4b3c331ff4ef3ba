"""Gives mouse and keys to the tool they are meant for."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from widgets.viewport.tools.tool import Pointer, Tool

CLICK_REACH = 4  # pixels


class Mouse(QObject):
    """The left button belongs to the armed tool, all else moves the picture.

    Holding Space lends the left button to that. Escape gives up what is half done,
    and puts the tool away when there is nothing.

    Signals
    -------
    armed(tool)
    hovered(x, y)
        Shares of the view, y down.
    context_requested(position)
        A right click that was no drag; global position.
    """

    armed = Signal(object)
    hovered = Signal(float, float)
    context_requested = Signal(QPoint)

    def __init__(self, widget: QWidget, navigate: Tool) -> None:
        super().__init__(widget)
        self._widget = widget
        self._navigate = navigate
        self._armed: Tool = navigate
        self._active: Tool | None = None
        self._pressed: Pointer | None = None
        self._space = False
        widget.installEventFilter(self)

    def arm(self, tool: Tool) -> None:
        """Give the left button to a tool."""
        self._armed.cancel()
        self._armed = tool
        self.armed.emit(tool)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Take an event of the widget, or leave it to Qt."""
        if isinstance(event, QWheelEvent):
            at = self._pointer(event.position(), Qt.MouseButton.NoButton, event.modifiers())
            self._navigate.turn_wheel(at, event.angleDelta().y() / 120)
            return True
        if isinstance(event, QMouseEvent):
            self._take_mouse(event)
            return True
        if isinstance(event, QKeyEvent):
            return self._take_key(event)
        return False

    def _take_mouse(self, event: QMouseEvent) -> None:
        at = self._pointer(event.position(), event.button(), event.modifiers())
        match event.type():
            case QEvent.Type.MouseButtonPress:
                self._press(at)
            case QEvent.Type.MouseButtonDblClick:
                self._navigate.double_click(at)
            case QEvent.Type.MouseMove if self._active is not None:
                self._active.move(at)
            case QEvent.Type.MouseMove:
                self.hovered.emit(at.x, at.y)
            case QEvent.Type.MouseButtonRelease:
                self._release(at, event.globalPosition().toPoint())

    def _take_key(self, event: QKeyEvent) -> bool:
        down = event.type() == QEvent.Type.KeyPress
        if event.key() == Qt.Key.Key_Space:
            self._space = down or (self._space and event.isAutoRepeat())
            return down
        if event.key() == Qt.Key.Key_Escape and down:
            self._active = self._pressed = None
            if not self._armed.cancel():
                self.arm(self._navigate)
            return True
        return False

    def _press(self, at: Pointer) -> None:
        if self._active is None:
            self._widget.setFocus(Qt.FocusReason.MouseFocusReason)
            left = at.button == Qt.MouseButton.LeftButton and not self._space
            self._active = self._armed if left else self._navigate
            self._pressed = at
            self._active.press(at)

    def _release(self, at: Pointer, where: QPoint) -> None:
        active, pressed = self._active, self._pressed
        if active is None or pressed is None or at.button != pressed.button:
            return
        self._active = self._pressed = None
        active.release(at)
        moved = max(abs(shift) for shift in at.pixels_from(pressed))
        if at.button == Qt.MouseButton.RightButton and moved <= CLICK_REACH:
            self.context_requested.emit(where)

    def _pointer(
        self, where: QPointF, button: Qt.MouseButton, modifiers: Qt.KeyboardModifier
    ) -> Pointer:
        width, height = max(1, self._widget.width()), max(1, self._widget.height())
        return Pointer(where.x() / width, where.y() / height, width, height, button, modifiers)
