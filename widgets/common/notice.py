"""A sentence in a panel that says what is missing, and a button that does something about it."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QVBoxLayout, QWidget


class Notice(QFrame):
    """Hidden as long as there is nothing to say.

    Signals
    -------
    clicked()
        The button was pressed.
    """

    clicked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._label = QLabel(self)
        self._label.setWordWrap(True)
        self.button = QPushButton(self)
        self.button.clicked.connect(self.clicked)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._label)
        layout.addWidget(self.button)
        self.say("")

    @property
    def text(self) -> str:
        """What it says; empty when it is hidden."""
        return self._label.text()

    def say(self, text: str, action: str = "") -> None:
        """Say something, with a button titled `action` if there is one; an empty text hides."""
        self._label.setText(text)
        self.button.setText(action)
        self.button.setVisible(bool(action))
        self.setAccessibleName(text)
        self.setVisible(bool(text))
