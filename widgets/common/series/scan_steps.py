"""The scans of a series in order, with what was found in each, and the way from one to the next."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from widgets.common.fact_table import FactTable

RIGHT, LEFT = Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft
LINES = 4


def set_slim(table: FactTable) -> None:
    """Rows as low as their text allows: these tables are long, and their panel is not."""
    table.verticalHeader().setDefaultSectionSize(round(table.fontMetrics().height() * 1.5))


class ScanSteps(QWidget):
    """A list to choose a scan from, with buttons and keys to step through it.

    Signals
    -------
    chosen(int)
        Place of a scan in the series.
    all_asked()
        Leaves are to be looked for in all scans.
    alone_asked()
        Whether other scans are hidden was changed.
    """

    chosen = Signal(int)
    all_asked = Signal()
    alone_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        titles = (self.tr("Scan"), "✓", "?", "✗", "✎")
        self.table = FactTable(
            self.tr("Scans of the series"), titles, self, (LEFT, RIGHT, RIGHT, RIGHT, RIGHT)
        )
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setMinimumHeight(self.fontMetrics().height() * (LINES + 2))
        set_slim(self.table)
        self.table.explain_columns(
            self.tr("Angle, time, treatment and label of the scan; ● is the reference"),
            self.tr("Leaves that were found for sure"),
            self.tr("Leaves to look at"),
            self.tr("Leaves that are not there"),
            self.tr("Leaves of which you said which points they have"),
        )
        self.previous = QPushButton("◀", self)
        self.next = QPushButton("▶", self)
        self.previous.setAccessibleName(self.tr("Previous scan"))
        self.next.setAccessibleName(self.tr("Next scan"))
        self.look_button = QPushButton(self.tr("&Look through all"), self)
        self.alone = QCheckBox(self.tr("Only this scan"), self)
        self.alone.setChecked(True)
        self.previous.setShortcut("Alt+Left")
        self.next.setShortcut("Alt+Right")
        self.previous.setToolTip(self.tr("The scan before (Alt+Left)"))
        self.next.setToolTip(self.tr("The scan after (Alt+Right)"))
        self.look_button.setToolTip(self.tr("Look for the leaves in every scan and count them"))
        self.alone.setToolTip(self.tr("Hide the other scans of the series in the picture"))
        buttons = QHBoxLayout()
        for widget in (self.previous, self.next, self.look_button, self.alone):
            buttons.addWidget(widget)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.table, 1)
        layout.addLayout(buttons)
        self.table.itemSelectionChanged.connect(self._on_selected)
        self.previous.clicked.connect(self.step_back)
        self.next.clicked.connect(self.step_on)
        self.look_button.clicked.connect(self.all_asked)
        self.alone.toggled.connect(self.alone_asked)

    @property
    def current(self) -> int:
        """Place of the chosen scan; -1 without one."""
        rows = self.table.selectionModel().selectedRows()
        return rows[0].row() if rows else -1

    def show_scans(self, rows: Sequence[Sequence[str]], tips: Sequence[str], current: int) -> None:
        """Show scans and counts; `current` is chosen (-1: none)."""
        with QSignalBlocker(self.table):
            self.table.show_rows(rows, tips)
            if current < 0:
                self.table.clearSelection()
            elif current != self.current:
                self.table.selectRow(current)
        self.previous.setEnabled(current > 0)
        self.next.setEnabled(current < len(rows) - 1)

    def step_back(self) -> None:
        """Choose the scan before."""
        self.table.selectRow(max(self.current - 1, 0))

    def step_on(self) -> None:
        """Choose the scan after."""
        self.table.selectRow(min(self.current + 1, self.table.rowCount() - 1))

    def _on_selected(self) -> None:
        if self.current >= 0:
            self.chosen.emit(self.current)
