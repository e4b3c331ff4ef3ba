"""The leaves of a scan as panels: which count, and how much light each sends back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from app.model.leaf import Leaf
from app.services.scan_panels import SeenPanel, guess_reflectance
from widgets.common.leaf_table import colour_of_leaf
from widgets.common.numbers import UNKNOWN, show_count, show_number, show_with_sd

NAME, RHO, SIGMA, DN = range(4)
LINES = 6


@dataclass(frozen=True, slots=True)
class Entry:
    """What the user says of a leaf: reflectance and its σ; None: no panel."""

    rho: float | None = None
    sigma: float = 0.0


class PanelList(QTableWidget):
    """Leaves with an editable reflectance; what was measured of them stands beside.

    Signals
    -------
    edited()
        The user typed a reflectance.
    """

    edited = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, 4, parent)
        self._entries: dict[str, Entry] = {}
        self._guesses: dict[str, Entry] = {}
        self._leaves: tuple[Leaf, ...] = ()
        self._items: list[list[QTableWidgetItem]] = []
        self.setAccessibleName(self.tr("Panels and their reflectance"))
        titles = (
            self.tr("Panel"),
            self.tr("Reflectance"),
            self.tr("± σ"),
            self.tr("DN"),
        )
        tips = (
            self.tr("A leaf of the scan that lies on a panel; rename it in the Leaves panel"),
            self.tr("Known reflectance as a fraction, 0.5 for 50 %; empty: no panel"),
            self.tr("How sure the reflectance is, as a fraction"),
            self.tr("Mean of the full hits; there when the panels were measured"),
        )
        for column, (title, tip) in enumerate(zip(titles, tips, strict=True)):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            side = Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.setHorizontalHeaderItem(column, item)
        self.verticalHeader().hide()
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setAlternatingRowColors(True)
        self.setTabKeyNavigation(True)
        triggers = QAbstractItemView.EditTrigger
        self.setEditTriggers(
            triggers.DoubleClicked | triggers.AnyKeyPressed | triggers.SelectedClicked
            | triggers.EditKeyPressed
        )  # fmt: skip
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
        self.setMinimumHeight(self.fontMetrics().height() * (LINES + 3))
        self.itemChanged.connect(self._on_changed)

    @property
    def entries(self) -> dict[str, Entry]:
        """Leaves that are panels, by key, with what is known of their reflectance."""
        found = {leaf.key: self._entry(leaf.key) for leaf in self._leaves}
        return {key: entry for key, entry in found.items() if entry.rho is not None}

    @property
    def in_percent(self) -> list[float]:
        """Reflectances that can only be percent."""
        return [e.rho for e in self.entries.values() if e.rho is not None and e.rho > 1.5]

    def show_leaves(self, leaves: Sequence[Leaf], names: Mapping[str, str]) -> None:
        """List leaves; `names` says which scan each is of, where there are several."""
        leaves = tuple(leaves)
        for leaf in leaves:
            if leaf.key not in self._entries:  # what was typed counts more than a name
                self._guesses[leaf.key] = Entry(guess_reflectance(leaf.name))
        if leaves == self._leaves:
            return
        self._leaves = leaves
        with QSignalBlocker(self):
            self.setRowCount(len(leaves))
            self._items = [self._make_row(leaf, names.get(leaf.scan, "")) for leaf in leaves]
            for row, items in enumerate(self._items):
                for column, item in enumerate(items):
                    self.setItem(row, column, item)
        self._write_numbers()

    @property
    def colours(self) -> dict[str, QColor]:
        """Colour of each panel, by its name: that of its first leaf."""
        found: dict[str, QColor] = {}
        for leaf in self._leaves:
            found.setdefault(leaf.name, colour_of_leaf(leaf.key))
        return found

    def forget(self) -> None:
        """Let go of what was typed for leaves of a document that is gone."""
        self._entries.clear()
        self._guesses.clear()
        self.show_leaves((), {})

    def show_seen(self, seen: Sequence[SeenPanel]) -> None:
        """Show what was measured."""
        found = {(each.panel.scan, each.panel.name): each for each in seen}
        with QSignalBlocker(self):
            for leaf, items in zip(self._leaves, self._items, strict=True):
                each = found.get((leaf.scan, leaf.name))
                dn = UNKNOWN if each is None else show_number(each.reading.dn, 1)
                if each is not None and not each.usable:
                    dn = self.tr("saturated")
                items[DN].setText(dn)
                items[DN].setToolTip("" if each is None else self._tell(each))

    def _entry(self, key: str) -> Entry:
        return self._entries.get(key, self._guesses.get(key, Entry()))

    def divide_percent(self) -> None:
        """Take all reflectances that were typed for percent; those of names are fractions."""
        for key, entry in self.entries.items():
            if entry.rho is not None and key in self._entries:
                self._entries[key] = replace(entry, rho=entry.rho / 100, sigma=entry.sigma / 100)
        self._write_numbers()
        self.edited.emit()

    def _tell(self, each: SeenPanel) -> str:
        reading = each.reading
        text = self.tr("{dn} DN, mean of {n} full hits at {range} m").format(
            dn=show_with_sd(reading.dn, reading.sigma),
            n=show_count(reading.n),
            range=show_number(reading.range_m, 3),
        )
        if each.usable:
            return text
        share = show_number(100.0 * each.saturated, 0)
        lost = self.tr("{0} % of its points are saturated: left out").format(share)
        return f"{text}\n{lost}"

    def _make_row(self, leaf: Leaf, scan: str) -> list[QTableWidgetItem]:
        name = f"{leaf.name}, {scan}" if scan else leaf.name
        items = [QTableWidgetItem(text) for text in (name, "", "", UNKNOWN)]
        for column, item in enumerate(items):
            if column not in (RHO, SIGMA):
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
            if column != NAME:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        items[NAME].setData(Qt.ItemDataRole.DecorationRole, colour_of_leaf(leaf.key))
        items[NAME].setToolTip(name)
        return items

    def _write_numbers(self) -> None:
        with QSignalBlocker(self):
            for leaf, items in zip(self._leaves, self._items, strict=True):
                entry = self._entry(leaf.key)
                items[RHO].setText("" if entry.rho is None else f"{entry.rho:g}")
                items[SIGMA].setText(f"{entry.sigma:g}" if entry.sigma else "")

    def _on_changed(self, item: QTableWidgetItem) -> None:
        """Take over a number; what is none is put back as it was."""
        key, column = self._leaves[item.row()].key, item.column()
        number = _read_number(item.text())
        if number is not None and column == RHO:
            self._entries[key] = replace(self._entry(key), rho=number or None)
        elif number is not None and column == SIGMA:
            self._entries[key] = replace(self._entry(key), sigma=number)
        self._write_numbers()
        self.edited.emit()


def _read_number(text: str) -> float | None:
    """A number from 0 on; 0 where there is no text, None where there is something else."""
    text = text.strip().replace(",", ".")
    percent = text.endswith("%")
    try:
        number = float(text.removesuffix("%").strip() or 0.0)
    except ValueError:
        return None
    number = number / 100 if percent else number
    return number if math.isfinite(number) and number >= 0.0 else None
