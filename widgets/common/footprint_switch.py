"""Switch for the footprints in the picture, how far apart they are, and the beam they need."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

MOST_EVERY = 50


class FootprintSwitch(QWidget):
    """Shows whether footprints are drawn, and asks for them.

    Signals
    -------
    toggled(bool), spaced(int)
        The user wants footprints, or none; rows and columns from one to the next.
    beam_asked()
        The user wants the scan to have the beam of the plan.
    """

    toggled = Signal(bool)
    spaced = Signal(int)
    beam_asked = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.shown = QCheckBox(self.tr("Show footprints &in the picture"), self)
        self.every = QSpinBox(self)
        self.beam_button = QPushButton(self.tr("&Use this beam for the scan"), self)
        self.every.setRange(1, MOST_EVERY)
        self._explain()
        self._lay_out()
        self.shown.toggled.connect(self.toggled)
        self.every.valueChanged.connect(self.spaced)
        self.beam_button.clicked.connect(self.beam_asked)

    def show_state(self, there: bool, shown: bool, every: int, beam_differs: bool) -> None:
        """Show what is the case, without a signal; `there` is whether a scan is open."""
        with QSignalBlocker(self.shown), QSignalBlocker(self.every):
            self.shown.setChecked(shown)
            self.every.setValue(every)
        self.shown.setEnabled(there)
        self.every.setEnabled(there and shown)
        self.beam_button.setEnabled(there and beam_differs)

    def _explain(self) -> None:
        self.shown.setToolTip(
            self.tr("The beam at true scale where it meets the selected points or the leaf")
        )
        self.every.setAccessibleName(self.tr("Rows and columns from footprint to footprint"))
        self.every.setToolTip(
            self.tr("Of a leaf, footprints in every so many rows and columns of the scan (1–50)")
        )
        self.beam_button.setToolTip(
            self.tr("Take the beam of the plan for the current scan, whose footprints are drawn")
        )

    def _lay_out(self) -> None:
        label = QLabel(self.tr("Rows and columns a&part, on a leaf"), self)
        label.setBuddy(self.every)
        row = QHBoxLayout()
        row.addWidget(label)
        row.addWidget(self.every)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.shown)
        layout.addLayout(row)
        layout.addWidget(self.beam_button, 0, Qt.AlignmentFlag.AlignLeft)
