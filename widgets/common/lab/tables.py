"""What the tables of the lab have in common: their height, and how they are copied."""

from __future__ import annotations

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QTableWidget

MOST_ROWS = 12
LINE = 1.5
"""Height of a row in heights of the font."""


def fit_height(table: QTableWidget, most: int = MOST_ROWS, wrapped: bool = False) -> None:
    """Make a table as high as its rows, up to some of them; wrapped texts take more lines."""
    line = round(LINE * table.fontMetrics().height())
    table.verticalHeader().setMinimumSectionSize(line)
    table.verticalHeader().setDefaultSectionSize(line)
    if wrapped:
        table.resizeRowsToContents()
    rows = min(max(table.rowCount(), 1), most)
    heights = sum(table.rowHeight(row) for row in range(min(rows, table.rowCount())))
    bar = table.horizontalScrollBar().sizeHint().height()
    table.setFixedHeight(heights + table.horizontalHeader().sizeHint().height() + bar + 4)


def table_as_text(table: QTableWidget) -> str:
    """Titles and cells, separated by tabs."""
    columns = range(table.columnCount())
    items = [[table.horizontalHeaderItem(column) for column in columns]]
    items += [[table.item(row, column) for column in columns] for row in range(table.rowCount())]
    lines = [["" if item is None else item.text() for item in row] for row in items]
    return "\n".join("\t".join(line) for line in lines)


def copy_table(table: QTableWidget) -> None:
    """Put a table on the clipboard, for a spreadsheet."""
    QGuiApplication.clipboard().setText(table_as_text(table))
