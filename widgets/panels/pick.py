"""Pick: the values of the point that was clicked."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication, QKeySequence, QShortcut
from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout

from app.model.events import EVERYTHING, Change
from widgets.common.fact_table import FactTable
from widgets.common.notice import Notice
from widgets.common.panel import Panel


class PickPanel(Panel):
    """Shows what is known of one point; copies it as a table."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("pick")
        self.setWindowTitle(self.tr("Point"))
        self._values: list[tuple[str, str, str]] = []
        self.notice = Notice(self)
        titles = (self.tr("Name"), self.tr("Value"), self.tr("Unit"))
        self.table = FactTable(self.tr("Values of the picked point"), titles, self)
        self.ghost = QLabel(self)
        self.ghost.setWordWrap(True)
        self.ghost.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.ghost.setAccessibleName(self.tr("Why this point is a ghost, or none"))
        self.ghost.setToolTip(
            self.tr(
                "In brackets how far surfaces lie along the beam from this point; negative: "
                "nearer to the scanner"
            )
        )
        self.ghost.hide()
        self.copy_button = QPushButton(self.tr("&Copy as table"), self)
        self.copy_button.setToolTip(self.tr("Names, values and units, separated by tabs"))
        self.copy_button.clicked.connect(self.copy)
        keys = QShortcut(QKeySequence.StandardKey.Copy, self.table)
        keys.setContext(Qt.ShortcutContext.WidgetShortcut)
        keys.activated.connect(self.copy)
        layout = QVBoxLayout(self)
        layout.addWidget(self.notice)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.ghost)
        layout.addWidget(self.copy_button, 0, Qt.AlignmentFlag.AlignLeft)
        layout.addStretch(0)

    def set_values(self, values: Sequence[tuple[str, str | float | int, str]]) -> None:
        """Show names, values and units; an empty sequence clears the panel."""
        self._values = [(name, _write(value), unit) for name, value, unit in values]
        if not values:
            self.explain("")
        self.refresh()

    def explain(self, text: str) -> None:
        """Show why the point is a ghost, or none; empty where nobody asked for a score."""
        self.ghost.setText(text)
        self.ghost.setVisible(bool(text) and bool(self._values))

    def on_document(self, change: Change) -> None:
        """Let go of a point whose document is gone."""
        if change is EVERYTHING:
            self._values = []
            self.explain("")
        super().on_document(change)

    def refresh(self) -> None:
        """Show the values, or how to get some."""
        empty = not self._values
        self.notice.say(
            self.tr("Click a point in the picture to see all that is known of it.") if empty else ""
        )
        self.table.setVisible(not empty)
        self.copy_button.setVisible(not empty)
        self.table.show_rows(self._values)

    def copy(self) -> None:
        """Put the table on the clipboard, a line per value, separated by tabs."""
        lines = ["\t".join(texts) for texts in self._values]
        if self.ghost.text():
            lines.append("\t".join((self.tr("Ghost"), self.ghost.text(), "")))
        QGuiApplication.clipboard().setText("\n".join(lines))
        self.controller.said.emit(self.tr("The point's values are on the clipboard."))


def _write(value: str | float | int) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)
