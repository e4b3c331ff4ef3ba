"""What the middle of the window shows as long as no scan is open."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from widgets.icons import load_mark


class Welcome(QWidget):
    """Two ways to begin, and nothing else."""

    def __init__(self, open_scan: QAction, demo: QAction, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(self.tr("Welcome"))
        self.open = QPushButton(self.tr("&Open a scan"), self)
        self.open.setProperty("primary", "true")
        self.open.clicked.connect(open_scan.trigger)
        self.demo = QPushButton(self.tr("Look at the &demo"), self)
        self.demo.clicked.connect(demo.trigger)
        self._lay_out()

    def _lay_out(self) -> None:
        em = self.fontMetrics().height()
        mark = QLabel(self)
        mark.setPixmap(load_mark().pixmap(5 * em))
        name = QLabel("Leafscope", self)
        name.setProperty("heading", "true")
        hint = QLabel(
            self.tr("Ctrl+O opens LAS, LAZ, E57, PTX, PLY, PCD and text; or drop files here."), self
        )
        hint.setProperty("faint", "true")
        hint.setWordWrap(True)
        hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        buttons = QHBoxLayout()
        buttons.setSpacing(em)
        buttons.addStretch()
        buttons.addWidget(self.open)
        buttons.addWidget(self.demo)
        buttons.addStretch()
        column = QVBoxLayout(self)
        column.setContentsMargins(2 * em, em, 2 * em, em)
        column.addStretch(2)
        column.addWidget(mark, 0, Qt.AlignmentFlag.AlignHCenter)
        column.addWidget(name, 0, Qt.AlignmentFlag.AlignHCenter)
        column.addSpacing(em)
        column.addLayout(buttons)
        column.addSpacing(em)
        column.addWidget(hint)
        column.addStretch(3)
