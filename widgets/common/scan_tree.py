"""Tree of the open scans, grouped by sample, with a box that shows or hides each."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTreeWidget,
    QTreeWidgetItem,
    QTreeWidgetItemIterator,
    QWidget,
)

from app.model.state import ScanState, State
from widgets.common.numbers import show_count

LEAST_LINES, MOST_LINES, LINE_GAP = 3, 8, 4
KEY = Qt.ItemDataRole.UserRole


class ScanTree(QTreeWidget):
    """Scans and samples; tells what the user does, changes nothing itself.

    Signals
    -------
    current_asked(str)
        The user wants to work on that scan.
    hiding_asked(tuple)
        Keys of the scans that shall not be drawn.
    name_asked(str, str)
        Key of a sample and its new name.
    """

    current_asked = Signal(str)
    hiding_asked = Signal(object)
    name_asked = Signal(str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shape: object = None
        self._current: str | None = None
        self.setAccessibleName(self.tr("Open scans"))
        self.setHeaderLabels([self.tr("Scan"), self.tr("Shown / total")])
        self.headerItem().setTextAlignment(1, Qt.AlignmentFlag.AlignRight)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setAlternatingRowColors(True)
        header = self.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.currentItemChanged.connect(self._on_current)
        self.itemChanged.connect(self._on_changed)

    def sizeHint(self) -> QSize:  # noqa: N802
        """As high as its lines, within reason: below it there is more to read."""
        lines = min(max(len(list(self.items())), LEAST_LINES), MOST_LINES)
        line = self.fontMetrics().height() + LINE_GAP
        height = self.header().sizeHint().height() + lines * line + 2 * self.frameWidth()
        return QSize(super().sizeHint().width(), height)

    @property
    def selected(self) -> list[str]:
        """Keys of the selected scans and samples."""
        return [item.data(0, KEY) for item in self.selectedItems()]

    def items(self) -> Iterator[QTreeWidgetItem]:
        """All items, samples before their scans."""
        walk = QTreeWidgetItemIterator(self)
        while (item := walk.value()) is not None:
            yield item
            walk += 1

    def show_scans(self, state: State, hidden: tuple[str, ...], current: str | None) -> None:
        """Show the scans that are open."""
        open_scans = {key: scan for key, scan in state.scans.items() if not scan.closed}
        samples = {key: (sample.name, sample.scans) for key, sample in state.samples.items()}
        with QSignalBlocker(self):
            shape = (tuple(open_scans), tuple(samples.items()))
            if shape != self._shape:
                self._shape = shape
                self._build(open_scans, samples)
                self.updateGeometry()
            for item in self.items():
                self._update(item, open_scans, hidden, current)
            if current != self._current or not self.selectedItems():
                self._current = current
                for item in self.items():
                    if item.data(0, KEY) == current:
                        self.setCurrentItem(item)

    def _build(
        self, scans: dict[str, ScanState], samples: dict[str, tuple[str, tuple[str, ...]]]
    ) -> None:
        self.clear()
        parents: dict[str, QTreeWidgetItem] = {}
        for key, (name, members) in samples.items():
            if not any(scan in scans for scan in members):
                continue
            item = QTreeWidgetItem(self, [name])
            item.setData(0, KEY, key)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsEditable)
            item.setExpanded(True)
            parents.update(dict.fromkeys(members, item))
        for key in scans:
            item = QTreeWidgetItem(parents.get(key, self))
            item.setData(0, KEY, key)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)

    def _update(
        self,
        item: QTreeWidgetItem,
        scans: dict[str, ScanState],
        hidden: tuple[str, ...],
        current: str | None,
    ) -> None:
        key = item.data(0, KEY)
        if key not in scans:
            return
        scan = scans[key]
        item.setText(0, scan.scan.name)
        item.setToolTip(0, self.tr("Tick to show the scan in the picture"))
        item.setText(1, f"{show_count(scan.shown)} / {show_count(len(scan.scan))}")
        item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        shown = Qt.CheckState.Unchecked if key in hidden else Qt.CheckState.Checked
        item.setCheckState(0, shown)
        font = item.font(0)
        font.setBold(key == current)
        item.setFont(0, font)

    def _on_current(self, item: QTreeWidgetItem | None, _: QTreeWidgetItem | None) -> None:
        if item is not None and self._is_scan(item):
            self.current_asked.emit(item.data(0, KEY))

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        if self._is_scan(item):
            hidden = [
                other.data(0, KEY)
                for other in self.items()
                if self._is_scan(other) and other.checkState(0) == Qt.CheckState.Unchecked
            ]
            self.hiding_asked.emit(tuple(hidden))
        elif column == 0:
            self.name_asked.emit(item.data(0, KEY), item.text(0))

    @staticmethod
    def _is_scan(item: QTreeWidgetItem) -> bool:
        return bool(item.flags() & Qt.ItemFlag.ItemIsUserCheckable) and bool(item.text(1))
