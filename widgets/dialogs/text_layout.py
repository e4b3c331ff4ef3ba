"""How the columns of a text file are read: the guess, shown on its first rows, to be corrected."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QSpinBox,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.text_layout import TextRows, find_layout, find_rows

SEPARATORS: tuple[tuple[str, str | None], ...] = (
    ("Guessed", None), ("Comma", ","), ("Semicolon", ";"), ("Tab", "tab"), ("Blanks", "space"),
)  # fmt: skip
UNITS: tuple[tuple[str, float], ...] = (("metres", 1.0), ("centimetres", 0.01),
                                        ("millimetres", 0.001))  # fmt: skip
MOST_HEADER_LINES = 999
MOST_ROWS = 12


class TextLayoutDialog(QDialog):
    """Shows the first rows under the names of their columns; names can be typed over.

    Signals
    -------
    chosen(ReadOptions)
        How the file is to be read.
    """

    chosen = Signal(object)

    def __init__(self, path: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("text-layout")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Columns of {0}").format(path.name))
        self._path = path
        self._names: tuple[str, ...] | None = None
        self.separator, self.unit = QComboBox(self), QComboBox(self)
        self.header_lines = QSpinBox(self)
        self.rows = QTableWidget(self)
        self.word = QLabel(self)
        standard = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(standard.Open | standard.Cancel, self)
        self._fill()
        self._lay_out()
        self._connect()
        self._guess_again()

    def options(self) -> ReadOptions:
        """How the file is to be read, as chosen."""
        lines = self.header_lines.value()
        return replace(
            DEFAULTS,
            separator=self.separator.currentData(),
            header_lines=lines if lines >= 0 else None,
            columns=self._names,
            metres_per_unit=float(self.unit.currentData()),
        )

    def accept(self) -> None:
        """Hand the choice on."""
        self.chosen.emit(self.options())
        super().accept()

    def _fill(self) -> None:
        for title, separator in SEPARATORS:
            self.separator.addItem(self.tr(title), separator)
        for title, metres in UNITS:
            self.unit.addItem(self.tr(title), metres)
        self.header_lines.setRange(-1, MOST_HEADER_LINES)
        self.header_lines.setValue(-1)
        self.header_lines.setSpecialValueText(self.tr("guessed"))
        self.rows.setAccessibleName(self.tr("First rows; the top row names the columns"))
        self.rows.horizontalHeader().hide()
        self.word.setWordWrap(True)

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        form = QFormLayout()
        form.addRow(self.tr("&Separator"), self.separator)
        form.addRow(self.tr("&Lines before the points"), self.header_lines)
        form.addRow(self.tr("&Unit of the coordinates"), self.unit)
        top = QHBoxLayout()
        top.addLayout(form)
        top.addStretch()
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.addLayout(top)
        hint = self.tr("Type x, y and z over the names of the coordinates; - leaves one out.")
        column.addWidget(QLabel(hint, self))
        column.addWidget(self.rows, 1)
        column.addWidget(self.word)
        column.addWidget(self.buttons)
        self.resize(44 * em, 30 * em)

    def _connect(self) -> None:
        self.separator.currentIndexChanged.connect(self._guess_again)
        self.header_lines.valueChanged.connect(self._guess_again)
        self.rows.itemChanged.connect(self._take_name)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)

    def _guess_again(self, *_: object) -> None:
        # Another separator makes other columns: names that were typed no longer fit.
        self._names = None
        self._check(show=True)

    def _take_name(self, item: QTableWidgetItem) -> None:
        if item.row() == 0:
            cells = [self.rows.item(0, column) for column in range(self.rows.columnCount())]
            texts = [cell.text().strip() if cell is not None else "" for cell in cells]
            self._names = tuple(text or "-" for text in texts)
            self._check(show=False)

    def _check(self, show: bool) -> None:
        able = self.buttons.button(QDialogButtonBox.StandardButton.Open)
        columns: tuple[str, ...] = ()
        try:
            layout = find_layout(self._path, self.options())
            columns = layout.columns
            self.word.setText(" ".join(layout.warnings))
        except LeafscopeError as error:
            self.word.setText(error.what)
        able.setEnabled(bool(columns))
        if show:
            self._show(columns)

    def _show(self, columns: tuple[str, ...]) -> None:
        self.rows.blockSignals(True)
        try:
            self._fill_table(find_rows(self._path, self.options()), columns)
        except LeafscopeError:
            self.rows.setRowCount(0)  # the sentence below the table says why it is empty
        self.rows.blockSignals(False)

    def _fill_table(self, rows: TextRows, columns: tuple[str, ...]) -> None:
        names = columns or tuple(f"column_{n}" for n in range(1, rows.width + 1))
        shown = rows.cells[:MOST_ROWS]
        self.rows.setRowCount(len(shown) + 1)
        self.rows.setColumnCount(len(names))
        self.rows.setVerticalHeaderLabels([self.tr("Name"), *map(str, range(1, len(shown) + 1))])
        for column, name in enumerate(names):
            self._put(0, column, name, editable=True)
            for number, row in enumerate(shown, 1):
                self._put(number, column, row[column] if column < len(row) else "", editable=False)
        self.rows.resizeColumnsToContents()

    def _put(self, row: int, column: int, text: str, editable: bool) -> None:
        item = QTableWidgetItem(text)
        if editable:
            font = self.font()
            font.setBold(True)
            item.setFont(font)
        else:
            item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
        self.rows.setItem(row, column, item)
