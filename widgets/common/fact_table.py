"""Small tables of facts: name, number, words."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

SIDES = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft)


class FactTable(QTableWidget):
    """Names to the left, numbers to the right, and, unless told otherwise, words to the left."""

    def __init__(
        self,
        name: str,
        titles: Sequence[str],
        parent: QWidget | None = None,
        sides: Sequence[Qt.AlignmentFlag] = SIDES,
    ) -> None:
        super().__init__(0, 0, parent)
        self.title_columns(titles, sides)
        self.setAccessibleName(name)
        self.verticalHeader().hide()
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)

    def title_columns(self, titles: Sequence[str], sides: Sequence[Qt.AlignmentFlag]) -> None:
        """Take other columns, each with the side to which its texts go."""
        self._sides = sides
        self.setColumnCount(len(titles))
        for column, title in enumerate(titles):
            self.setHorizontalHeaderItem(column, self._make_item(title, column))

    def explain_columns(self, *tips: str) -> None:
        """Give the titles tool tips, from the left."""
        for column, tip in enumerate(tips):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                item.setToolTip(tip)

    def show_rows(self, rows: Sequence[Sequence[str]], tips: Sequence[str] = ()) -> None:
        """Show rows of texts, each with a tool tip if there are any."""
        self.setRowCount(len(rows))
        for row, texts in enumerate(rows):
            for column, text in enumerate(texts):
                item = self._make_item(text, column)
                item.setToolTip(tips[row] if tips else text)
                self.setItem(row, column, item)

    def _make_item(self, text: str, column: int) -> QTableWidgetItem:
        item = QTableWidgetItem(text)
        item.setTextAlignment(self._sides[column] | Qt.AlignmentFlag.AlignVCenter)
        return item
