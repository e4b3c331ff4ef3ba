"""The scans of a series as a table: which is the reference, and what each of them is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QButtonGroup,
    QHBoxLayout,
    QHeaderView,
    QRadioButton,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from app.services.series.entries import Entry, parse_number
from app.services.series.filling import Filled

REFERENCE, NAME, ANGLE, HOURS, TREATMENT, LABEL, NOTE = range(7)
NUMBERS = {ANGLE: "angle_deg", HOURS: "hours"}
WORDS = {TREATMENT: "treatment", LABEL: "label"}


@dataclass(frozen=True, slots=True)
class ScanRow:
    """A scan that may come into a series.

    Attributes
    ----------
    file : Path
    scan : str
        Its key where it is open; empty where it is still to be opened.
    entry : Entry
    problem : str
        Why something of it cannot be understood.
    """

    file: Path
    scan: str
    entry: Entry
    problem: str = ""


class EntryTable(QTableWidget):
    """Scans with an editable angle, time, treatment and label, and a mark on the reference.

    Signals
    -------
    edited()
        Something is different.
    """

    edited = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, 7, parent)
        self.rows: list[ScanRow] = []
        self._group = QButtonGroup(self)
        self.setAccessibleName(self.tr("Scans of the series"))
        for column, (title, tip) in enumerate(self._titles()):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            self.setHorizontalHeaderItem(column, item)
        self.verticalHeader().hide()
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setAlternatingRowColors(True)
        self.setTabKeyNavigation(True)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        triggers = QAbstractItemView.EditTrigger
        self.setEditTriggers(
            triggers.DoubleClicked
            | triggers.AnyKeyPressed
            | triggers.SelectedClicked
            | triggers.EditKeyPressed
        )
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(NOTE, QHeaderView.ResizeMode.Stretch)
        self.itemChanged.connect(self._on_changed)

    def _titles(self) -> tuple[tuple[str, str], ...]:
        return (
            (self.tr("Reference"), self.tr("The scan whose leaves are carried to the others")),
            (self.tr("Scan"), self.tr("File or name of the scan")),
            (self.tr("Angle (°)"), self.tr("Angle of the holder in degrees; any number")),
            (self.tr("Hours"), self.tr("When it was scanned, in hours; any number")),
            (self.tr("Treatment"), self.tr("Group of the leaves, such as watered or dry")),
            (self.tr("Label"), self.tr("Any words")),
            (self.tr("Note"), self.tr("What cannot be understood, and why")),
        )

    @property
    def reference(self) -> int:
        """Row of the reference; -1 without rows."""
        return self._group.checkedId()

    @property
    def files(self) -> list[Path]:
        """Files of all rows."""
        return [row.file for row in self.rows]

    @property
    def problems(self) -> int:
        """How many rows cannot be understood."""
        return sum(bool(row.problem) for row in self.rows)

    def show_rows(self, rows: Iterable[ScanRow], reference: int = 0) -> None:
        """Show these scans."""
        self.rows = list(rows)
        for button in self._group.buttons():
            self._group.removeButton(button)
        with QSignalBlocker(self):
            self.setRowCount(len(self.rows))
            for number in range(len(self.rows)):
                self._make_row(number)
        self.choose_reference(reference)
        self.edited.emit()

    def choose_reference(self, number: int) -> None:
        """Make a row the reference."""
        button = self._group.button(number)
        if button is not None:
            button.setChecked(True)

    def remove_selected(self) -> None:
        """Leave the selected scans out."""
        gone = {index.row() for index in self.selectedIndexes()}
        reference = self.reference
        kept = [k for k in range(len(self.rows)) if k not in gone]
        place = kept.index(reference) if reference in kept else 0
        self.show_rows([self.rows[k] for k in kept], place)

    def fill(self, filled: Filled, columns: Sequence[int]) -> None:
        """Take over what names or a table say; only these columns are touched."""
        names = {**NUMBERS, **WORDS}
        for number, (entry, problem) in enumerate(
            zip(filled.entries, filled.problems, strict=True)
        ):
            row = self.rows[number]
            told = {} if entry is None else {names[c]: getattr(entry, names[c]) for c in columns}
            self.rows[number] = replace(row, entry=replace(row.entry, **told), problem=problem)
        with QSignalBlocker(self):
            for number in range(len(self.rows)):
                self._write(number)
        self.edited.emit()

    def _make_row(self, number: int) -> None:
        button = QRadioButton(self)
        button.setToolTip(self.tr("Carry the leaves of this scan to the others"))
        button.setAccessibleName(
            self.tr("{scan} is the reference").format(scan=self.rows[number].file.name)
        )
        self._group.addButton(button, number)
        cell = QWidget(self)
        layout = QHBoxLayout(cell)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(button, 0, Qt.AlignmentFlag.AlignCenter)
        self.setCellWidget(number, REFERENCE, cell)
        for column in range(NAME, NOTE + 1):
            item = QTableWidgetItem()
            if column in (NAME, NOTE):
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
            if column in NUMBERS:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.setItem(number, column, item)
        self._write(number)

    def _write(self, number: int) -> None:
        row = self.rows[number]
        texts = {
            NAME: row.file.name,
            ANGLE: show_value(row.entry.angle_deg),
            HOURS: show_value(row.entry.hours),
            TREATMENT: row.entry.treatment,
            LABEL: row.entry.label,
            NOTE: row.problem or ("" if row.scan else self.tr("will be opened")),
        }
        for column, text in texts.items():
            item = self.item(number, column)
            if item is not None:
                item.setText(text)
                item.setToolTip(str(row.file) if column == NAME else row.problem)

    def _on_changed(self, item: QTableWidgetItem) -> None:
        number, column, text = item.row(), item.column(), item.text().strip()
        row = self.rows[number]
        typed: dict[str, Any] = {}
        problem = row.problem
        if column in NUMBERS:
            try:
                typed, problem = {NUMBERS[column]: parse_number(text) if text else None}, ""
            except ValueError:
                problem = self.tr("{text} is not a number.").format(text=text[:20])
        elif column in WORDS:
            typed = {WORDS[column]: text}
        self.rows[number] = replace(row, entry=replace(row.entry, **typed), problem=problem)
        with QSignalBlocker(self):
            self._write(number)
        self.edited.emit()


def show_value(value: float | None) -> str:
    """A number as it is typed: with a point, and no more digits than it has."""
    return "" if value is None else f"{value:.10g}"
