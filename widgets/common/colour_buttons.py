"""Buttons that colour the view by a field; the one in use is pressed."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGridLayout, QPushButton, QWidget

Row = tuple[str, str, str]
"""Text, field, tool tip."""


class ColourButtons(QWidget):
    """A few fields to colour the view by, in rows of `columns`.

    Signals
    -------
    asked(str)
        The user wants this field; empty: it was in use, and another one is wanted.
    """

    asked = Signal(str)

    def __init__(self, columns: int, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._columns = columns
        self._rows: tuple[Row, ...] = ()
        self.buttons: dict[str, QPushButton] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)

    def show_fields(self, rows: Sequence[Row], colour: str) -> None:
        """Offer fields; `colour` is the one in use."""
        if tuple(rows) != self._rows:
            self._rows = tuple(rows)
            for button in self.buttons.values():
                self._grid.removeWidget(button)
                button.deleteLater()
            self.buttons = {field: self._make(*row) for row in rows for field in (row[1],)}
            for place, button in enumerate(self.buttons.values()):
                self._grid.addWidget(button, place // self._columns, place % self._columns)
        for field, button in self.buttons.items():
            button.setChecked(field == colour)
        self.setVisible(bool(rows))

    def _make(self, text: str, field: str, tip: str) -> QPushButton:
        button = QPushButton(text, self)
        button.setCheckable(True)
        button.setToolTip(tip)
        button.setAccessibleName(self.tr("Colour the view by {0}").format(field))
        button.setObjectName(field)
        button.clicked.connect(self._on_click)
        return button

    def _on_click(self, wanted: bool) -> None:
        field = str(self.sender().objectName())
        self.asked.emit(field if wanted else "")
