"""Names and values in two columns: the small tables of facts."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QFormLayout, QLabel, QWidget


class FactGrid(QWidget):
    """Facts as name and value; values can be selected and copied."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._layout = QFormLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setRowWrapPolicy(QFormLayout.RowWrapPolicy.DontWrapRows)
        self._values: dict[str, QLabel] = {}

    @property
    def texts(self) -> dict[str, str]:
        """What is shown, by name."""
        return {name: label.text() for name, label in self._values.items()}

    def show_facts(self, facts: Iterable[tuple[str, str]]) -> None:
        """Show facts in this order; labels are made anew only when the names differ."""
        found = dict(facts)
        if list(found) != list(self._values):
            while self._layout.rowCount():
                self._layout.removeRow(0)
            self._values = {name: self._add(name) for name in found}
        for name, text in found.items():
            self._values[name].setText(text)

    def _add(self, name: str) -> QLabel:
        title, value = QLabel(name, self), QLabel(self)
        title.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        value.setTextFormat(Qt.TextFormat.PlainText)
        value.setWordWrap(True)
        value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._layout.addRow(title, value)
        return value
