"""Single letters for the clean-up, where otherwise they are shortcuts of the window."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from weakref import WeakMethod

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

Deed = Callable[[], object]


class SessionKeys(QObject):
    """Gives letters to the clean-up while it is on, in the widgets that are told.

    Qt asks the widget with the focus before it looks for a shortcut (ShortcutOverride): who
    accepts gets the key, so no action of the window is ambiguous or lost for long.

    Parameters
    ----------
    deeds : mapping of Qt.Key to bound method
    active : callable
        Whether the clean-up is on.
    """

    def __init__(
        self, deeds: Mapping[Qt.Key, Deed], active: Callable[[], bool], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._deeds = {key.value: WeakMethod(deed) for key, deed in deeds.items()}
        self._active = WeakMethod(active)

    def serve(self, *widgets: QWidget) -> None:
        """Listen to widgets too."""
        for widget in widgets:
            widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Take a letter that is ours."""
        if not isinstance(event, QKeyEvent):
            return False
        deed, active = self._deeds.get(event.key()), self._active()
        plain = event.modifiers() in (
            Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.KeypadModifier
        )  # fmt: skip
        if deed is None or active is None or not plain or not active():
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
            return True
        if event.type() != QEvent.Type.KeyPress:
            return False
        found = deed()
        if found is not None:
            found()
        return True
