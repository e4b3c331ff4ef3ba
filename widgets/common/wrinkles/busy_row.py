"""The button that measures, or stops; how far it is; whether what is shown is out of date."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QWidget,
)

STEPS = 1000


class BusyRow(QWidget):
    """Measure, cancel, progress.

    Signals
    -------
    asked()
        Measure.
    cancelled()
        Stop.
    """

    asked = Signal()
    cancelled = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.button = QPushButton(self.tr("&Measure wrinkles"), self)
        self.button.setProperty("primary", "true")
        self.button.setToolTip(self.tr("Of all leaves of the scan, in the background"))
        self.stop = QPushButton(self.tr("Cance&l"), self)
        self.stop.setToolTip(self.tr("Stop; what was measured before stays"))
        self.bar = QProgressBar(self)
        self.bar.setRange(0, STEPS)
        self.bar.setTextVisible(False)
        self.bar.setAccessibleName(self.tr("Progress"))
        self.words = QLabel(self)
        self.words.setWordWrap(True)
        layout = QGridLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.button, 0, 0)
        layout.addWidget(self.stop, 0, 1)
        layout.addWidget(self.bar, 0, 2)
        layout.addWidget(self.words, 1, 0, 1, 3)
        layout.setColumnStretch(2, 1)
        self.button.clicked.connect(self.asked)
        self.stop.clicked.connect(self.cancelled)
        self.show_state(False)

    def show_state(self, busy: bool, words: str = "") -> None:
        """Say whether it is at work, and something beside."""
        self.button.setEnabled(not busy)
        self.stop.setVisible(busy)
        self.bar.setVisible(busy)
        if not busy:
            self.bar.setValue(0)
        self.words.setText(words)
        self.words.setVisible(bool(words))

    def show_progress(self, fraction: float, text: str) -> None:
        """Say how far it is."""
        self.bar.setValue(round(STEPS * fraction))
        self.bar.setToolTip(text)
