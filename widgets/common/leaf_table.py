"""The leaves of a scan as a table: numbers stay numbers, text is made when it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor

from app.core.indices import NAMED
from app.model.leaf import Leaf
from app.model.scan import Channel
from app.render.palettes import colours
from app.services.leaves import Row, key_number
from widgets.common.numbers import UNKNOWN, show_count, show_number, show_with_sd

Index = QModelIndex | QPersistentModelIndex
SORT = Qt.ItemDataRole.UserRole


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its title with the unit, and how a measured leaf fills it."""

    title: str
    tip: str
    value: Callable[[Row], float | None]
    text: Callable[[Row], str]


def colour_of_leaf(key: str) -> QColor:
    """The colour of a leaf, the same as in the picture."""
    number = np.array([float(key_number(key))])
    return QColor(*(int(c) for c in colours(number, 0.0, 1.0, "leaves")[0]))


class LeafTable(QAbstractTableModel):
    """Leaves with what was measured of them; the name can be edited.

    Signals
    -------
    name_asked(str, str)
        Key of a leaf and its new name.
    """

    name_asked = Signal(str, str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.leaves: tuple[Leaf, ...] = ()
        self.columns: tuple[Column, ...] = ()
        self._rows: Mapping[str, Row] = {}

    def show_leaves(
        self,
        leaves: Sequence[Leaf],
        rows: Mapping[str, Row],
        channels: Sequence[Channel],
    ) -> None:
        """Show leaves; those without a row yet have empty numbers."""
        columns = self._make_columns(rows, channels)
        same = [leaf.key for leaf in leaves] == [leaf.key for leaf in self.leaves]
        if same and [c.title for c in columns] == [c.title for c in self.columns]:
            self.leaves, self._rows = tuple(leaves), dict(rows)
            if leaves:
                last = self.index(len(leaves) - 1, self.columnCount() - 1)
                self.dataChanged.emit(self.index(0, 0), last)
            return
        self.beginResetModel()
        self.leaves, self.columns, self._rows = tuple(leaves), columns, dict(rows)
        self.endResetModel()

    def find_row(self, key: str | None) -> int:
        """Row of a leaf; -1 when it is not here."""
        keys = [leaf.key for leaf in self.leaves]
        return keys.index(key) if key in keys else -1

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008
        """One row per leaf."""
        return 0 if parent.isValid() else len(self.leaves)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008
        """Name, points and what is measured."""
        return 0 if parent.isValid() else len(self.columns) + 2

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Only the name can be edited."""
        flags = super().flags(index)
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == 0 else flags

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:  # noqa: N802
        """Titles with units."""
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = self.columns[section - 2] if section >= 2 else None
        if role == Qt.ItemDataRole.DisplayRole:
            if column is not None:
                return column.title
            return self.tr("Points") if section else self.tr("Leaf")
        if role == Qt.ItemDataRole.ToolTipRole and column is not None:
            return column.tip
        if role == Qt.ItemDataRole.TextAlignmentRole:
            side = Qt.AlignmentFlag.AlignRight if section else Qt.AlignmentFlag.AlignLeft
            return side | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Text, numbers to sort by, the colour of the leaf."""
        leaf, column = self.leaves[index.row()], index.column()
        if role == Qt.ItemDataRole.TextAlignmentRole and column:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if role == Qt.ItemDataRole.DecorationRole and column == 0:
            return colour_of_leaf(leaf.key)
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return self._write(leaf, column)
        if role == SORT:
            return self._sort_by(leaf, column)
        if role == Qt.ItemDataRole.ToolTipRole and column >= 2:
            return self._explain(leaf, column)
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:  # noqa: N802
        """Ask for another name; the document decides."""
        if role != Qt.ItemDataRole.EditRole or index.column() != 0:
            return False
        self.name_asked.emit(self.leaves[index.row()].key, str(value).strip())
        return True

    def _write(self, leaf: Leaf, column: int) -> str:
        if column == 0:
            return leaf.name
        row = self._rows.get(leaf.key)
        if column == 1:
            points = len(leaf.members) if row is None else int(row["points"] or 0)
            return show_count(points)
        return "…" if row is None else self.columns[column - 2].text(row)

    def _explain(self, leaf: Leaf, column: int) -> str | None:
        """Why there is no area, or what it stands for."""
        if self.columns[column - 2].value is not _area_of:
            return None
        told = self._rows.get(leaf.key, {}).get("area_of")
        return None if told is None else str(told)

    def _sort_by(self, leaf: Leaf, column: int) -> str | float:
        if column == 0:
            return leaf.key
        if column == 1:
            return float(len(leaf.members))
        row = self._rows.get(leaf.key)
        value = None if row is None else self.columns[column - 2].value(row)
        return -math.inf if value is None else value

    def _make_columns(
        self, rows: Mapping[str, Row], channels: Sequence[Channel]
    ) -> tuple[Column, ...]:
        known = {name for row in rows.values() for name in row}
        columns = [
            _area(
                self.tr("Area (cm²)"),
                self.tr(
                    "Area of the leaf's mesh and its 95 % interval; ≥: a lower bound, of a leaf "
                    "that something hides or that is seen nearly edge-on"
                ),
            ),
            _plain(
                self.tr("ω plane (°)"),
                self.tr("Angle between the beam and the normal of the leaf's plane"),
                "incidence_plane_deg",
                1,
            ),
            _plain(
                self.tr("sd of ω (°)"),
                self.tr("Spread of the local angles of its points: how bent the leaf is"),
                "incidence_sd_deg",
                1,
            ),
        ]
        for channel in channels:
            nm = channel.wavelength_nm
            title = channel.name if nm is None else f"{nm:g} nm"
            unit = f" ({channel.kind})" if channel.kind in ("DN", "dB") else ""
            tip = self.tr("{channel}: mean ± standard deviation of the points").format(
                channel=channel.name
            )
            columns.append(_mean_sd(f"{title}{unit}", tip, channel.name))
        for index in NAMED.values():
            if f"{index.name}_of_means" in known:
                columns += self._index_columns(index.name, index.title)
        return tuple(columns)

    def _index_columns(self, name: str, title: str) -> list[Column]:
        return [
            _mean_sd(
                self.tr("{index}, mean of points").format(index=name.upper()),
                self.tr("{index}, computed for each point, then averaged").format(index=title),
                name,
                "_mean_of_points",
            ),
            _plain(
                self.tr("{index} of means").format(index=name.upper()),
                self.tr("{index} of the mean channel values").format(index=title),
                f"{name}_of_means",
                3,
            ),
        ]


def _number(row: Row, name: str) -> float | None:
    value = row.get(name)
    return float(value) if isinstance(value, (int, float)) else None


def _plain(title: str, tip: str, name: str, decimals: int) -> Column:
    def text(row: Row) -> str:
        return UNKNOWN if row.get(name) is None else show_number(_number(row, name), decimals)

    return Column(title, tip, lambda row: _number(row, name), text)


def _mean_sd(title: str, tip: str, name: str, mean: str = "_mean") -> Column:
    def text(row: Row) -> str:
        return show_with_sd(_number(row, name + mean), _number(row, f"{name}_sd"))

    return Column(title, tip, lambda row: _number(row, name + mean), text)


def _area_of(row: Row) -> float | None:
    return _number(row, "area_cm2")


def _area(title: str, tip: str) -> Column:
    def text(row: Row) -> str:
        if "area_of" not in row:
            return "…"
        area, low, high = (_number(row, f"area{end}_cm2") for end in ("", "_low", "_high"))
        if area is None:
            return UNKNOWN
        if row["area_of"] != "leaf" or low is None or high is None:
            return f"≥ {show_number(area, 1)}"
        return f"{show_number(area, 1)} ({show_number(low, 1)}–{show_number(high, 1)})"

    return Column(title, tip, _area_of, text)
