"""Leaves under each workflow side by side: mean, spread, points, and how many are marked."""

from __future__ import annotations

import re
from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from app.services.leaves import Row
from app.services.workflow_preview import TOGETHER
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.numbers import UNKNOWN, count_decimals, show_count, show_number

SHORT = {"wf1": "WF1", "wf2": "WF2", "wf3": "WF3", "wf3_subtracted": "WF3 subtr."}
MOST_ROWS, LINES = 5, 3
"""Rows that are seen at once: all together and four leaves; lines of a cell."""
WIDEST_NAME = 5
SMALLER = 0.88
"""Size of the numbers beside that of the window: three columns have to fit a narrow panel."""
THIN = "\u2009"


class WorkflowGrid(QTableWidget):
    """A row per leaf, a column per workflow; a cell has a number on each line."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, 0, parent)
        self.setAccessibleName(self.tr("Leaves under each workflow"))
        self.setToolTip(
            self.tr(
                "Mean ± standard deviation of the points; coefficient of variation (sd / mean); "
                "number of points with a value; ⚠, points that are marked"
            )
        )
        self.verticalHeader().hide()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.horizontalHeader().setHighlightSections(False)
        self.setWordWrap(False)
        self._small = self.font()
        self._small.setPointSizeF(SMALLER * self._small.pointSizeF())

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Show rows of one channel, as `compare_workflows` gives them."""
        there = [w for w in SHORT if any(f"{w}_n" in row for row in rows)]
        self.setColumnCount(1 + len(there))
        rows = sorted(rows, key=_place)
        self.setRowCount(len(rows))
        self.setHorizontalHeaderLabels([self.tr("Leaf"), *(SHORT[w] for w in there)])
        for line, row in enumerate(rows):
            self._show_name(line, row)
            for column, workflow in enumerate(there, 1):
                self._show_cell(line, column, row, workflow)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Fixed)
        self.resizeColumnToContents(0)
        em = self.fontMetrics().height()
        self.setColumnWidth(0, min(self.columnWidth(0), WIDEST_NAME * em))
        # All rows of one height: measuring every cell takes longer than a frame.
        tall = round((SMALLER * LINES + 0.4) * em)
        self.verticalHeader().setDefaultSectionSize(tall)
        high = min(len(rows), MOST_ROWS) * tall
        self.setFixedHeight(high + header.sizeHint().height() + 2 * self.frameWidth() + 2)

    def _show_name(self, line: int, row: Row) -> None:
        item = QTableWidgetItem(str(row["name"]))
        together = row["leaf"] == TOGETHER
        if together:
            font = self.font()
            font.setBold(True)
            item.setFont(font)
            item.setText(self.tr("Together"))
            item.setToolTip(
                self.tr("All points of the leaves that were chosen, or of the whole scan")
            )
        else:
            item.setData(Qt.ItemDataRole.DecorationRole, colour_of_leaf(str(row["leaf"])))
            item.setToolTip(item.text())
        self.setItem(line, 0, item)

    def _show_cell(self, line: int, column: int, row: Row, workflow: str) -> None:
        if f"{workflow}_n" not in row:
            self.setItem(line, column, QTableWidgetItem(UNKNOWN))
            return
        mean, sd, cv = (_number(row, f"{workflow}_{what}") for what in ("mean", "sd", "cv"))
        count, marked = int(row[f"{workflow}_n"] or 0), int(row[f"{workflow}_marked"] or 0)
        share = self.tr("CV {0} %").format(show_number(None if cv is None else 100 * cv, 1))
        decimals = count_decimals(mean, sd)
        both = f"{show_number(mean, decimals)}{THIN}±{THIN}{show_number(sd, decimals)}"
        number = show_count(count)
        if marked and workflow != "wf1":
            number += f" ⚠{THIN}{show_count(marked)}"
        item = QTableWidgetItem("\n".join((both, share, number)))
        item.setFont(self._small)
        item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        tip = self.tr("{by}; n {n} points with a value, {marked} marked").format(
            by=row.get(f"{workflow}_by") or self.tr("as it was calibrated"),
            n=show_count(count), marked=show_count(marked),
        )  # fmt: skip
        item.setToolTip(tip)
        self.setItem(line, column, item)


def _place(row: Row) -> tuple[bool, list[tuple[int, str]]]:
    """All together first, then leaves by name, numbers in it by their size."""
    parts = re.split(r"(\d+)", str(row["name"]).casefold())
    return row["leaf"] != TOGETHER, [
        (int(part), "") if part.isdecimal() else (0, part) for part in parts
    ]


def _number(row: Row, name: str) -> float | None:
    value = row.get(name)
    return float(value) if isinstance(value, (int, float)) else None
