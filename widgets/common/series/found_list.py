"""The leaves in one scan of a series: how sure each is, and what the user can say of it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.core.units import to_mm
from app.services.series.carrying import Found
from widgets.common.fact_table import FactTable
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.numbers import UNKNOWN, show_count, show_number
from widgets.common.series.scan_steps import set_slim
from widgets.common.series.words import explain, name_verdict, show_share

RIGHT, LEFT = Qt.AlignmentFlag.AlignRight, Qt.AlignmentFlag.AlignLeft
LINES = 4


class FoundList(QWidget):
    """Leaves as they were found, and four buttons for those that are selected.

    Signals
    -------
    confirmed(), taken(), missed(), reset()
        The user says: it is so; it has the selected points; it is not there; look again.
    selected()
        Other leaves are selected.
    """

    confirmed = Signal()
    taken = Signal()
    missed = Signal()
    reset = Signal()
    selected = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.found: tuple[Found, ...] = ()
        self._reference, self._points = False, 0
        titles = (self.tr("Leaf"), self.tr("Found"), self.tr("Points"), "%", "mm")
        self.table = FactTable(
            self.tr("Leaves in this scan"), titles, self, (LEFT, LEFT, RIGHT, RIGHT, RIGHT)
        )
        self.table.setMinimumHeight(self.fontMetrics().height() * (LINES + 2))
        set_slim(self.table)
        self.table.explain_columns(
            self.tr("Leaf of the reference scan, in its colour in the picture"),
            self.tr("✓ sure, ? somebody should look, ✗ not there, ✎ you said so"),
            self.tr("Points here, and in the reference scan"),
            self.tr("Share of the leaf that was found, percent"),
            self.tr("How far along the beam it is from where it was carried to, mm"),
        )
        self.words = QLabel(self)
        self.words.setWordWrap(True)
        self.confirm_button = QPushButton(self.tr("&Confirm"), self)
        self.take_button = QPushButton(self.tr("Use &selection"), self)
        self.miss_button = QPushButton(self.tr("&Not there"), self)
        self.reset_button = QPushButton(self.tr("&Reset"), self)
        for button, tip in (
            (self.confirm_button, self.tr("The selected leaves have the points that are shown")),
            (self.take_button, self.tr("The leaf has the points that are selected in this scan: "
                                       "draw around them with the lasso first")),
            (self.miss_button, self.tr("The selected leaves are not in this scan")),
            (self.reset_button, self.tr("Forget what you said of the selected leaves here")),
        ):  # fmt: skip
            button.setToolTip(tip)
        buttons = QGridLayout()
        four = (self.confirm_button, self.take_button, self.miss_button, self.reset_button)
        for place, button in enumerate(four):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.words)
        layout.addLayout(buttons)
        self.confirm_button.clicked.connect(self.confirmed)
        self.take_button.clicked.connect(self.taken)
        self.miss_button.clicked.connect(self.missed)
        self.reset_button.clicked.connect(self.reset)
        self.table.itemSelectionChanged.connect(self._on_selected)

    @property
    def chosen(self) -> tuple[Found, ...]:
        """The selected leaves."""
        rows = sorted(index.row() for index in self.table.selectionModel().selectedRows())
        return tuple(self.found[row] for row in rows if row < len(self.found))

    def show_found(self, found: Sequence[Found], reference: bool, points: int, leaf: str) -> None:
        """Show leaves.

        Parameters
        ----------
        found : sequence of Found
        reference : bool
            They are in their own scan: nothing can be said of them here.
        points : int
            How many points are selected in the scan.
        leaf : str
            Key of the leaf that is selected where none is.
        """
        kept = {one.leaf.key for one in self.chosen} or {leaf}
        self.found, self._reference = tuple(found), reference
        with QSignalBlocker(self.table):
            self.table.show_rows([_write(one, reference) for one in found],
                                 [explain(one, reference) for one in found])  # fmt: skip
            self._decorate()
            self._select(kept)
        self._points = points
        self._tell()

    def _decorate(self) -> None:
        for row, one in enumerate(self.found):
            item = self.table.item(row, 0)
            if item is not None:
                item.setData(Qt.ItemDataRole.DecorationRole, colour_of_leaf(one.leaf.key))

    def _select(self, keys: set[str]) -> None:
        selection = self.table.selectionModel()
        flags = selection.SelectionFlag
        selection.clearSelection()
        for row, one in enumerate(self.found):
            if one.leaf.key in keys:
                index = self.table.model().index(row, 0)
                selection.select(index, flags.Select | flags.Rows)

    def _tell(self) -> None:
        chosen = self.chosen
        self.words.setText(explain(chosen[0], self._reference) if len(chosen) == 1 else "")
        free = bool(chosen) and not self._reference
        self.confirm_button.setEnabled(free and any(len(one.rows) for one in chosen))
        self.take_button.setEnabled(free and len(chosen) == 1 and self._points > 0)
        self.miss_button.setEnabled(free)
        self.reset_button.setEnabled(free and any(o.verdict == "corrected" for o in chosen))

    def _on_selected(self) -> None:
        self._tell()
        self.selected.emit()


def _write(one: Found, reference: bool) -> list[str]:
    here, there = show_count(len(one.rows)), show_count(len(one.leaf.rows))
    offset = UNKNOWN if one.offset != one.offset else show_number(to_mm(one.offset), 1)
    return [
        one.leaf.name,
        "●" if reference else name_verdict(one),
        here if reference else f"{here} / {there}",
        show_share(one.share).rstrip("%"),
        offset,
    ]
