"""Which index, and of which leaves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QWidget,
)

from widgets.common.index.choice import Choice

What = Literal["each", "chosen", "leaf", "together", "scan"]


class IndexForm(QWidget):
    """The choice that both pages work with.

    Signals
    -------
    changed()
        The user chose something else.
    own_asked()
        The user wants to write an index.
    """

    changed = Signal()
    own_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.index_box, self.leaves_box = QComboBox(self), QComboBox(self)
        self.own_button = QPushButton(self.tr("&Own…"), self)
        self.picks = QLabel(self)
        self._choices: list[Choice] = []
        for title, data in (
            (self.tr("Each leaf"), "each"),
            (self.tr("All leaves together"), "together"),
            (self.tr("Selected leaves"), "chosen"),
            (self.tr("Current leaf"), "leaf"),
            (self.tr("Whole scan"), "scan"),
        ):
            self.leaves_box.addItem(title, data)
        self._lay_out()
        self.index_box.activated.connect(self._on_choice)
        self.leaves_box.activated.connect(self._on_choice)
        self.own_button.clicked.connect(self.own_asked)

    @property
    def index(self) -> str:
        """Name of the index; empty when none can be had."""
        return str(self.index_box.currentData() or "")

    @property
    def what(self) -> What:
        """Which leaves."""
        found: What = self.leaves_box.currentData()
        return found

    def fill(self, choices: Sequence[Choice]) -> None:
        """Offer indices; keep the one that was chosen if it can still be had."""
        if list(choices) == self._choices:
            return
        self._choices, box, kept = list(choices), self.index_box, self.index
        there = [choice.name for choice in choices if not choice.missing]
        with QSignalBlocker(box):
            box.clear()
            for choice in choices:
                box.addItem(choice.title, choice.name)
            model = box.model()
            for row, choice in enumerate(choices):
                if isinstance(model, QStandardItemModel):
                    model.item(row).setEnabled(not choice.missing)
                    model.item(row).setToolTip(choice.missing or choice.name)
            wanted = kept if kept in there else there[0] if there else ""
            box.setCurrentIndex(box.findData(wanted))

    def _lay_out(self) -> None:
        for box in (self.index_box, self.leaves_box):
            box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            box.setMinimumContentsLength(10)
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
        self.index_box.setAccessibleName(self.tr("Index"))
        self.index_box.setToolTip(self.tr("Named indices and your own; greyed where a channel "
                                          "is missing"))  # fmt: skip
        self.leaves_box.setAccessibleName(self.tr("Leaves"))
        self.leaves_box.setToolTip(self.tr("Flat leaves hold few angles each: take them together"))
        self.own_button.setToolTip(self.tr("Write indices of your own as formulas"))
        self.picks.setWordWrap(True)
        self.picks.setProperty("faint", "true")
        line = QHBoxLayout()
        line.addWidget(self.index_box, 1)
        line.addWidget(self.own_button)
        index, leaves = QLabel(self.tr("&Index"), self), QLabel(self.tr("&Leaves"), self)
        index.setBuddy(self.index_box)
        leaves.setBuddy(self.leaves_box)
        # No form: it gives a wrapped label far too much room.
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setColumnStretch(1, 1)
        grid.addWidget(index, 0, 0)
        grid.addLayout(line, 0, 1)
        grid.addWidget(self.picks, 1, 1)
        grid.addWidget(leaves, 2, 0)
        grid.addWidget(self.leaves_box, 2, 1)

    def _on_choice(self, _: int) -> None:
        self.changed.emit()
