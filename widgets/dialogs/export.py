"""Export: which points, which fields, which format; says what will be written."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMessageBox,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from app.services.export import Portion, chosen_points, judgements
from widgets.common.numbers import show_count
from widgets.controller import Controller
from widgets.dialogs.open_scan import FileDialogs
from widgets.documents import Documents
from widgets.fields_at_hand import FieldAtHand, list_fields

FORMATS = {
    ".laz": "LAZ: compressed LAS, all fields as extra bytes",
    ".las": "LAS: all fields as extra bytes",
    ".e57": "E57: with pose and grid",
    ".ptx": "PTX: text, one line per cell of the grid",
    ".ply": "PLY: binary",
    ".csv": "CSV: text, one row per point",
    ".npz": "NPZ: arrays for Python",
}
PORTIONS: tuple[tuple[Portion, str], ...] = (
    ("everything", "&Everything"),
    ("selection", "The &selection"),
    ("complement", "All &but the selection"),
)


class ExportDialog(QDialog):
    """Asks what to write of the current scan; an existing file only after a question."""

    def __init__(
        self,
        controller: Controller,
        documents: Documents,
        dialogs: FileDialogs,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("export")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._documents, self._dialogs = documents, dialogs
        self._project, self._key = controller.project, controller.current or ""
        self._state = self._project.state.scan(self._key)
        self.setWindowTitle(self.tr("Export {0}").format(self._state.scan.name))
        self._counts = {p: len(chosen_points(self._project, self._key, p)) for p, _ in PORTIONS}
        self.portions = QButtonGroup(self)
        self.fields = QListWidget(self)
        self.format = QComboBox(self)
        self.summary = QLabel(self)
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel, self)
        self._fill()
        self._lay_out()
        self._summarise()

    def portion(self) -> Portion:
        """Which points."""
        return PORTIONS[self.portions.checkedId()][0]

    def chosen_fields(self) -> list[str]:
        """Names of the fields that are ticked."""
        items = [self.fields.item(row) for row in range(self.fields.count())]
        ticked = [item for item in items if item.checkState() == Qt.CheckState.Checked]
        return [str(item.data(Qt.ItemDataRole.UserRole)) for item in ticked]

    def suffix(self) -> str:
        """Suffix of the format."""
        return str(self.format.currentData())

    def columns(self) -> list[str]:
        """Names of what will be written beside the coordinates."""
        names = [*self._state.scan.attributes, *self.chosen_fields()]
        names += list(judgements(self._project, self._key))
        if self._state.scan.grid is not None:
            names += ["row", "column"]
        return list(dict.fromkeys(names))

    def accept(self) -> None:
        """Ask for the file; its dialog asks about one that exists."""
        stem = Path(self._state.scan.name).stem
        suggested = self._dialogs.folder / f"{stem}-{self.portion()}{self.suffix()}"
        self._dialogs.ask_save(suggested, self._write, self)

    def _write(self, path: Path) -> None:
        source = self._state.scan.source
        if source is not None and path.exists() and path.samefile(Path(source.path)):
            QMessageBox(
                QMessageBox.Icon.Warning,
                self.windowTitle(),
                self.tr("This is the file that the scan came from. Choose another name."),
                parent=self,
            ).open()
            return
        self._documents.export(path, self.portion(), self.chosen_fields())
        super().accept()

    def _fill(self) -> None:
        for number, (portion, title) in enumerate(PORTIONS):
            count = show_count(self._counts[portion])
            button = QRadioButton(self.tr("{0} ({1} points)").format(self.tr(title), count), self)
            button.setEnabled(self._counts[portion] > 0)
            self.portions.addButton(button, number)
        self.portions.button(0).setChecked(True)
        self.portions.idToggled.connect(self._summarise)
        for suffix, text in FORMATS.items():
            self.format.addItem(self.tr(text), suffix)
        for field in list_fields(self._project, self._key):
            if field.name not in self._state.scan.attributes and not field.missing:
                self._add_field(field)
        self.fields.itemChanged.connect(self._summarise)
        self.fields.setAccessibleName(self.tr("Fields to compute and write"))
        write = self.buttons.addButton(self.tr("&Write…"), QDialogButtonBox.ButtonRole.AcceptRole)
        write.setDefault(True)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)

    def _add_field(self, field: FieldAtHand) -> None:
        unit = f" ({field.unit})" if field.unit else ""
        item = QListWidgetItem(f"{field.title}{unit}", self.fields)
        item.setData(Qt.ItemDataRole.UserRole, field.name)
        known = self._project.known_field(self._key, field.name)
        there = known is not None and known.complete
        item.setCheckState(Qt.CheckState.Checked if there else Qt.CheckState.Unchecked)
        item.setToolTip(self.tr("Computed already") if there else self.tr("Will be computed"))

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        grid = QGridLayout()
        grid.setHorizontalSpacing(em)
        grid.addWidget(QLabel(self.tr("Points")), 0, 0, Qt.AlignmentFlag.AlignTop)
        choices = QVBoxLayout()
        for button in self.portions.buttons():
            choices.addWidget(button)
        grid.addLayout(choices, 0, 1)
        fields = QLabel(self.tr("&Fields"))
        fields.setBuddy(self.fields)
        grid.addWidget(fields, 1, 0, Qt.AlignmentFlag.AlignTop)
        grid.addWidget(self.fields, 1, 1)
        self.fields.setMinimumSize(24 * em, 9 * em)
        form = QLabel(self.tr("F&ormat"))
        form.setBuddy(self.format)
        grid.addWidget(form, 2, 0)
        grid.addWidget(self.format, 2, 1)
        self.summary.setWordWrap(True)
        self.summary.setProperty("faint", "true")
        column = QVBoxLayout(self)
        column.setContentsMargins(em, em, em, em)
        column.setSpacing(em // 2)
        column.addLayout(grid)
        column.addWidget(self.summary)
        column.addWidget(self.buttons)

    def _summarise(self) -> None:
        names = ["x", "y", "z", *self.columns()]
        count = show_count(self._counts[self.portion()])
        text = self.tr("{0} points with {1} columns: {2}. Deleted points are left out.")
        self.summary.setText(text.format(count, len(names), ", ".join(names)))
