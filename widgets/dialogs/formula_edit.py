"""A line for a formula that completes the names of channels and functions."""

from __future__ import annotations

import re
from collections.abc import Iterable

from PySide6.QtCore import QStringListModel, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QCompleter, QLineEdit, QWidget

WORD = re.compile(r"\w+$")
LEAST = 1
KEYS = (Qt.Key.Key_Enter, Qt.Key.Key_Return, Qt.Key.Key_Escape, Qt.Key.Key_Tab)


class FormulaEdit(QLineEdit):
    """Offers what begins with the word before the cursor."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._names = QStringListModel(self)
        self.completion = QCompleter(self._names, self)
        self.completion.setWidget(self)
        self.completion.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.completion.activated.connect(self.complete_word)

    def offer(self, names: Iterable[str]) -> None:
        """Names to complete."""
        self._names.setStringList(sorted(set(names)))

    def insert_name(self, name: str) -> None:
        """Put a name at the cursor, with spaces where they are needed."""
        before = self.text()[: self.cursorPosition()]
        self.insert(f" {name}" if before and (before[-1].isalnum() or before[-1] == "_") else name)
        self.setFocus()

    def complete_word(self, name: str) -> None:
        """Put a name in the place of the word before the cursor."""
        place = self.cursorPosition()
        start = place - len(self._word())
        text = self.text()
        self.setText(text[:start] + name + text[place:])
        self.setCursorPosition(start + len(name))

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Type, then offer names."""
        popup = self.completion.popup()
        assert popup is not None  # noqa: S101 - Qt makes it when it is asked for
        if popup.isVisible() and event.key() in KEYS:
            event.ignore()  # the list of names takes it
            return
        super().keyPressEvent(event)
        word = self._word()
        if len(word) < LEAST or not event.text().isprintable() or not event.text():
            popup.hide()
            return
        self.completion.setCompletionPrefix(word)
        if self.completion.completionCount() and self.completion.currentCompletion() != word:
            place = self.cursorRect()
            place.setWidth(popup.sizeHintForColumn(0) + 4 * self.fontMetrics().height())
            self.completion.complete(place)
        else:
            popup.hide()

    def _word(self) -> str:
        found = WORD.search(self.text()[: self.cursorPosition()])
        return found[0] if found else ""
