"""All leaves of a scan with their wrinkles: sortable, linked with the leaf that is looked at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from PySide6.QtCore import QSortFilterProxyModel, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from app.model.leaf import Leaf
from app.model.scan import Channel
from app.services.leaves import Row
from widgets.common.leaf_table import SORT, Column, Index, LeafTable
from widgets.common.numbers import UNKNOWN, show_number, show_signed

ROWS = 5
LINE = 1.5
POINTS = 1
"""The column of points, which the share of valid ones tells more of."""


class WrinkleModel(LeafTable):
    """The numbers of wrinkles beside each leaf; the tip of a row says what is missing."""

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """As leaves have it; why a leaf has no numbers as its tip."""
        if role == Qt.ItemDataRole.ToolTipRole:
            row = self._rows.get(self.leaves[index.row()].key)
            return None if row is None else row.get("refusal") or row.get("claim")
        return super().data(index, role)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:  # noqa: N802
        """Titles to the left, where the arrow of the order does not cover them."""
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        return super().headerData(section, orientation, role)

    def _make_columns(
        self, rows: Mapping[str, Row], channels: Sequence[Channel]
    ) -> tuple[Column, ...]:
        return (
            Column(
                self.tr("Index (°)"),
                self.tr("Wrinkle index: spread of the tilts of its parts beyond noise and a "
                        "smooth bend, degrees; its 95 % interval"),
                _read("wrinkle_index_deg"), _tell_index,
            ),
            _text(self.tr("Shape"), self.tr("Unimodal, skewed or several modes of Δω"), "shape"),
            _plain(self.tr("ω plane (°)"), self.tr("Angle between beam and the leaf's plane"),
                   "omega_plane_deg"),
            _plain(self.tr("Shift (°)"),
                   self.tr("ω of the leaf's mean intensity less ω of its plane"),
                   "omega_of_mean_intensity_minus_plane_deg", signed=True),
            _plain(self.tr("sd Δω (°)"), self.tr("Standard deviation of Δω, noise and all"),
                   "delta_sd_deg"),
            Column(self.tr("Valid (%)"), self.tr("Share of points with a valid angle"),
                   _share, lambda row: show_number(_share(row), 0)),
        )  # fmt: skip


class WrinkleTable(QTableView):
    """The table; a click chooses the leaf that all panels look at.

    Signals
    -------
    chosen(str)
        Key of the leaf that was clicked.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._showing = False
        self.leaves = WrinkleModel(self)
        self._sorted = QSortFilterProxyModel(self)
        self._sorted.setSourceModel(self.leaves)
        self._sorted.setSortRole(SORT)
        self.setModel(self._sorted)
        self._dress()
        self.selectionModel().currentRowChanged.connect(self._on_row)

    def show_leaves(self, leaves: Sequence[Leaf], rows: Mapping[str, Row], current: str) -> None:
        """Show leaves; those that were not measured have no numbers yet."""
        self._showing = True  # a table that is filled anew has no row of its own accord
        self.leaves.show_leaves(leaves, rows, ())
        self.setColumnHidden(POINTS, True)
        self.select_leaf(current)

    def select_leaf(self, key: str) -> None:
        """Show which leaf is looked at; tells nobody."""
        row = self.leaves.find_row(key)
        selection = self.selectionModel()
        self._showing = True
        if row < 0:
            selection.clear()
        else:
            index = self._sorted.mapFromSource(self.leaves.index(row, 0))
            flags = selection.SelectionFlag
            selection.setCurrentIndex(index, flags.ClearAndSelect | flags.Rows)
            self.scrollTo(index)
        self._showing = False

    def _on_row(self, index: Index, _: Index) -> None:
        if index.isValid() and not self._showing:
            self.chosen.emit(self.leaves.leaves[self._sorted.mapToSource(index).row()].key)

    def _dress(self) -> None:
        self.setAccessibleName(self.tr("Wrinkles of all leaves"))
        self.setSortingEnabled(True)
        self.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        line = round(LINE * self.fontMetrics().height())
        self.verticalHeader().hide()
        self.verticalHeader().setMinimumSectionSize(line)
        self.verticalHeader().setDefaultSectionSize(line)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setHighlightSections(False)
        self.setMinimumHeight(header.sizeHint().height() + ROWS * line)


def _read(name: str) -> Any:
    def value(row: Row) -> float | None:
        found = row.get(name)
        return float(found) if isinstance(found, (int, float)) else None

    return value


def _plain(title: str, tip: str, name: str, signed: bool = False) -> Column:
    value = _read(name)
    show = show_signed if signed else show_number
    return Column(title, tip, value, lambda row: show(value(row), 1))


def _text(title: str, tip: str, name: str) -> Column:
    order = ("too few points", "unimodal", "skewed", "several modes")

    def value(row: Row) -> float | None:
        word = row.get(name)
        return float(order.index(str(word))) if word in order else None

    return Column(title, tip, value, lambda row: str(row.get(name) or UNKNOWN))


def _tell_index(row: Row) -> str:
    value, low, high = (_read(f"wrinkle_index{part}_deg")(row) for part in ("", "_low", "_high"))
    if value is None:
        return UNKNOWN
    return f"{show_number(value, 1)} ({show_number(low, 1)}–{show_number(high, 1)})"


def _share(row: Row) -> float | None:
    valid, points = _read("valid")(row), _read("points")(row)
    return None if valid is None or not points else 100.0 * valid / points
