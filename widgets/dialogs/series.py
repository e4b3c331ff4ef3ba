"""Make a series: which scans, what each of them is, and which one the leaves come from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.services.series.entries import Entry, Understood, read_entries
from app.services.series.file_names import guess_pattern, match_names, read_names
from app.services.series.filling import Filled, Reader, fill_entries
from app.services.series.memory import Need, estimate_need
from app.services.series.order import list_scans
from widgets.common.notice import Notice
from widgets.common.series.entry_table import (
    ANGLE,
    HOURS,
    LABEL,
    TREATMENT,
    EntryTable,
    ScanRow,
)
from widgets.controller import Controller
from widgets.dialogs.open_scan import FileDialogs


@dataclass(frozen=True, slots=True)
class WantedSeries:
    """What the user asks for: a name, the scans, and which of them is the reference."""

    name: str
    rows: tuple[ScanRow, ...]
    reference: int


Then = Callable[[WantedSeries], object]


class SeriesDialog(QDialog):
    """Calls `then` with the series that is asked for."""

    def __init__(
        self,
        controller: Controller,
        rows: Iterable[ScanRow],
        dialogs: FileDialogs,
        then: Then,
        parent: QWidget | None = None,
        name: str = "",
        reference: int = -1,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("series")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Change the series") if name else self.tr("Make a series"))
        self._controller, self._dialogs, self._then = controller, dialogs, then
        self._counted: list[Path] = []
        self._fits, self._closed = True, False
        rows = list(rows)
        folders = {row.file.parent.name for row in rows} - {""}
        self.name = QLineEdit(
            name or (folders.pop() if len(folders) == 1 else self.tr("Series")), self
        )
        self.pattern = QLineEdit(self)
        self.by_names = QPushButton(self.tr("&Fill from names"), self)
        self.by_table = QPushButton(self.tr("Fill from a &CSV…"), self)
        self.add_files = QPushButton(self.tr("&Add scans…"), self)
        self.add_folder = QPushButton(self.tr("Add a f&older…"), self)
        self.remove = QPushButton(self.tr("&Leave out"), self)
        self.table = EntryTable(self)
        self.notice = Notice(self)
        self.facts = QLabel(self)
        standard = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(standard.Ok | standard.Cancel, self)
        self.start = self.buttons.button(standard.Ok)
        self.start.setText(self.tr("Change series") if name else self.tr("&Make series"))
        self._explain()
        self._lay_out()
        self._connect()
        self.table.show_rows(rows, max(reference, 0))
        if reference < 0:
            self._guess()

    def wanted(self) -> WantedSeries:
        """What is asked for."""
        return WantedSeries(self.name.text().strip(), tuple(self.table.rows), self.table.reference)

    def done(self, result: int) -> None:
        """Close; nobody waits for the headers any more."""
        self._closed = True
        super().done(result)

    def accept(self) -> None:
        """Hand over what is asked for."""
        wanted = self.wanted()
        super().accept()
        self._then(wanted)

    def take_files(self, paths: Sequence[Path]) -> None:
        """Add files, and the scans of folders; those that are there already are left out."""
        try:
            files = list_scans(paths)
        except LeafscopeError as error:
            self.notice.say(str(error))
            return
        there = set(self.table.files)
        new = [ScanRow(file, "", Entry(file)) for file in files if file not in there]
        rows, reference = [*self.table.rows, *new], self.table.reference
        if not self.table.rows and files:
            self.name.setText(files[0].parent.name or self.name.text())
        self.table.show_rows(rows, max(reference, 0))
        self._guess()

    def fill_by_names(self) -> None:
        """Fill the table by the pattern; names that do not fit are told."""
        pattern = self.pattern.text().strip()

        def read(files: Sequence[Path]) -> Understood:
            return match_names(files, pattern) if pattern else read_names(files)

        self._fill(read)

    def fill_by_table(self, path: Path) -> None:
        """Fill the table from a CSV, joined by file name."""

        def read(files: Sequence[Path]) -> Understood:
            return read_entries(files, path)

        self._fill(read)

    def _guess(self) -> None:
        """Propose a pattern, and what follows from it."""
        files = self.table.files
        if len(files) < 2:
            return
        try:
            self.pattern.setText(guess_pattern(files))
        except LeafscopeError as error:
            self.notice.say(str(error))
            return
        self.fill_by_names()
        self._guess_reference()

    def _guess_reference(self) -> None:
        """The scan nearest to angle 0, else the first in time: its leaves look largest."""
        entries = [row.entry for row in self.table.rows]
        angles = [(abs(e.angle_deg), k) for k, e in enumerate(entries) if e.angle_deg is not None]
        hours = [(e.hours, k) for k, e in enumerate(entries) if e.hours is not None]
        self.table.choose_reference(min(angles or hours or [(0.0, 0)])[1])

    def _fill(self, read: Reader) -> None:
        try:
            filled = fill_entries(self.table.files, read)
        except LeafscopeError as error:
            self.notice.say(str(error))
            return
        self.table.fill(filled, _columns(filled))
        self.notice.say(self._tell(filled))

    def _tell(self, filled: Filled) -> str:
        how = self.tr("Understood: {how}.").format(how=filled.how)
        if filled.bad == 0:
            return how
        bad = self.tr("Scans that do not fit: {n}; their rows say why.").format(n=filled.bad)
        return f"{how} {bad}"

    def _check(self) -> None:
        """Find out how much memory the scans need that are to be opened."""
        new = [row.file for row in self.table.rows if not row.scan]
        if new != self._counted:
            self._counted, self._fits = new, not new
            self.facts.setVisible(bool(new))
            self.facts.setText(self.tr("Looking at the scans…"))
            if new:
                title = self.tr("Looking at the headers of scans")
                self._controller.run(title, partial(_look_at, new), self._tell_need)
        self._enable()

    def _tell_need(self, found: tuple[list[Path], Need | str]) -> None:
        files, need = found
        if self._closed or files != self._counted:
            return
        if isinstance(need, str):
            self.facts.setText(need)
        else:
            self._fits = need.fits
            more = self.tr(
                "Leave scans out, or let the command leafscope series measure the folder: it "
                "holds two scans at a time."
            )
            self.facts.setText(need.describe() if need.fits else f"{need.describe()} {more}")
        self._enable()

    def _enable(self) -> None:
        rows = self.table.rows
        ready = self._fits and len(rows) > 1 and not self.table.problems
        self.start.setEnabled(ready and bool(self.name.text().strip()))
        self.by_names.setEnabled(bool(rows))
        self.by_table.setEnabled(bool(rows))
        self.start.setToolTip(
            "" if ready else self.tr("A series needs two scans or more, and no row with a problem")
        )

    def _explain(self) -> None:
        self.facts.setWordWrap(True)
        self.facts.setVisible(False)
        self.name.setToolTip(self.tr("What the series is called"))
        self.pattern.setToolTip(
            self.tr(
                "How names are read: {angle} degrees, {hours}, {time} such as 2024-05-01T10-30, "
                "{treatment}, {label}; * stands for anything"
            )
        )
        self.pattern.setPlaceholderText("leaf_{angle}.laz")
        for button, tip in (
            (self.by_names, self.tr("Read angles, times and words from the names of the files")),
            (
                self.by_table,
                self.tr("A table with a column file, and angle, hours, time, treatment or label"),
            ),
            (
                self.add_files,
                self.tr("Scans that are not open yet; the series opens them"),
            ),
            (self.add_folder, self.tr("All scans of a folder")),
            (self.remove, self.tr("Take the selected rows out of the series")),
        ):
            button.setToolTip(tip)
            button.setAutoDefault(False)

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.addRow(self.tr("&Name"), self.name)
        naming = QHBoxLayout()
        naming.addWidget(self.pattern, 1)
        naming.addWidget(self.by_names)
        naming.addWidget(self.by_table)
        form.addRow(self.tr("&Pattern of names"), naming)
        label = form.labelForField(naming)
        if isinstance(label, QLabel):
            label.setBuddy(self.pattern)
        edit = QHBoxLayout()
        for button in (self.add_files, self.add_folder, self.remove):
            edit.addWidget(button)
        edit.addStretch(1)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.notice)
        layout.addWidget(self.table, 1)
        layout.addLayout(edit)
        layout.addWidget(self.facts)
        layout.addWidget(self.buttons)
        em = self.fontMetrics().height()
        self.resize(56 * em, 38 * em)

    def _connect(self) -> None:
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self.table.edited.connect(self._check)
        self.name.textChanged.connect(self._enable)
        self.pattern.returnPressed.connect(self.fill_by_names)
        self.by_names.clicked.connect(self.fill_by_names)
        self.by_table.clicked.connect(self._ask_table)
        self.add_files.clicked.connect(self._ask_files)
        self.add_folder.clicked.connect(self._ask_folder)
        self.remove.clicked.connect(self.table.remove_selected)

    def _ask_table(self) -> None:
        title = self.tr("A table of angles or times")
        self._dialogs.ask_file(title, ".csv", self.fill_by_table, self)

    def _ask_files(self) -> None:
        self._dialogs.ask_open(self.take_files, self)

    def _ask_folder(self) -> None:
        self._dialogs.ask_folder(self.tr("A folder of scans"), self._take_folder, self)

    def _take_folder(self, folder: Path) -> None:
        self.take_files([folder])


def _columns(filled: Filled) -> list[int]:
    """Columns of which something is said."""
    told = [entry for entry in filled.entries if entry is not None]
    values = {
        ANGLE: any(entry.angle_deg is not None for entry in told),
        HOURS: any(entry.hours is not None for entry in told),
        TREATMENT: any(entry.treatment for entry in told),
        LABEL: any(entry.label for entry in told),
    }
    return [column for column, there in values.items() if there]


def _look_at(files: list[Path], _: Progress) -> tuple[list[Path], Need | str]:
    """What opening files takes, or why it cannot be told; runs in the worker."""
    try:
        return files, estimate_need(files)
    except LeafscopeError as error:
        return files, str(error)
