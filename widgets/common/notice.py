"""A sentence in place of what cannot be shown yet, with the button that helps."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget


class Notice(QFrame):
    """Says in words what is missing and what to do; hidden when there is nothing to say.

    Signals
    -------
    clicked()
        The button was pressed.
    """

    clicked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        # The style sheet of the window gives this property its ground.
        self.setProperty("notice", "info")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)
        self._label = QLabel(self)
        self._label.setWordWrap(True)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.button = QPushButton(self)
        self.button.setProperty("primary", "true")
        self.button.clicked.connect(self.clicked)
        layout = QVBoxLayout(self)
        layout.addWidget(self._label)
        layout.addWidget(self.button, 0, Qt.AlignmentFlag.AlignLeft)
        self.say("")

    @property
    def text(self) -> str:
        """What is said; empty when it is hidden."""
        return self._label.text()

    def say(self, text: str, action: str = "") -> None:
        """Show a sentence, and a button if there is something to press; nothing hides both."""
        self._label.setText(text)
        self.button.setText(action)
        self.button.setVisible(bool(action))
        self.setAccessibleName(text)
        self.setVisible(bool(text))
