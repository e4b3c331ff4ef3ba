"""A button with a menu of what can be written to a file."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QPushButton, QWidget


class ExportButton(QPushButton):
    """Asks which kind of file.

    Signals
    -------
    asked(str)
        The kind that was chosen.
    """

    asked = Signal(str)

    def __init__(self, kinds: Sequence[tuple[str, str]], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setText(self.tr("&Export"))
        self.setToolTip(self.tr("Write tables or pictures"))
        menu = QMenu(self)
        for kind, title in kinds:
            action = QAction(title, menu)
            action.setObjectName(kind)
            menu.addAction(action)
        menu.triggered.connect(self._on_action)
        self.setMenu(menu)

    def _on_action(self, action: QAction) -> None:
        self.asked.emit(action.objectName())
