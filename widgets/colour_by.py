"""Choose the field that colours the points; what cannot be had says why."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QStandardItem, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QWidget

from app.model.events import Change
from widgets.controller import Controller
from widgets.fields_at_hand import MEASURED, FieldAtHand, list_fields

NAME = int(Qt.ItemDataRole.UserRole)
WIDEST = 28  # heights of a line
CONCERNS = {"scans", "channels", "pose", "leaves", "parameters"}


class ColourBy(QComboBox):
    """Fields of the current scan in groups; greyed where something is missing."""

    def __init__(self, controller: Controller, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._listed: list[FieldAtHand] = []
        self._model = QStandardItemModel(self)
        self.setModel(self._model)
        self.setAccessibleName(self.tr("Colour by"))
        self.setToolTip(self.tr("The field that colours the points"))
        self.setMaxVisibleItems(40)
        self.setMinimumContentsLength(16)
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.setSizeAdjustPolicy(policy)
        self.activated.connect(self._choose)
        controller.document_changed.connect(self._follow_document)
        controller.view_changed.connect(self._follow_view)
        self.rebuild()

    def rebuild(self) -> None:
        """List the fields of the current scan anew."""
        key = self._controller.current
        fields = list_fields(self._controller.project, key) if key is not None else []
        if fields != self._listed or self._model.rowCount() == 0:
            self._listed = fields
            with QSignalBlocker(self):
                self._fill(fields)
        self.setEnabled(key is not None)
        self._show_choice()

    def _fill(self, fields: list[FieldAtHand]) -> None:
        self._model.clear()
        self._add(self.tr("Plain"), "", self.tr("No colours"))
        group = ""
        for field in fields:
            if field.group != group:
                group = field.group
                self._add_heading(self.tr(group))
            unit = f" ({field.unit})" if field.unit else ""
            item = self._add(field.title, field.name, field.missing or f"{field.name}{unit}")
            item.setEnabled(not field.missing)
        em = self.fontMetrics().height()
        longest = max((self.fontMetrics().horizontalAdvance(f.title) for f in fields), default=0)
        # A formula in a title may be of any length.
        self.view().setMinimumWidth(min(longest, WIDEST * em) + 4 * em)
        self.view().setTextElideMode(Qt.TextElideMode.ElideMiddle)

    def _add(self, title: str, name: str, tip: str) -> QStandardItem:
        item = QStandardItem(title)
        item.setData(name, NAME)
        item.setToolTip(tip)
        self._model.appendRow(item)
        return item

    def _add_heading(self, title: str) -> None:
        item = QStandardItem(title)
        item.setFlags(Qt.ItemFlag.NoItemFlags)
        font = self.font()
        font.setBold(True)
        item.setFont(font)
        self._model.appendRow(item)

    def _choose(self, row: int) -> None:
        name = self.itemData(row, NAME)
        if name is not None and name != self._controller.view.colour:
            self._controller.look(colour=str(name))

    def _show_choice(self) -> None:
        with QSignalBlocker(self):
            self.setCurrentIndex(max(self.findData(self._controller.view.colour, NAME), 0))

    def _follow_document(self, change: Change) -> None:
        if change.aspects & CONCERNS or change.fields & set(MEASURED):
            self.rebuild()

    def _follow_view(self, view: object) -> None:
        self.rebuild()
