"""History: every step that was done, and the way back to each of them."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLabel, QListWidget, QListWidgetItem, QVBoxLayout

from app.model.events import Change
from widgets.common.numbers import show_count
from widgets.common.panel import Panel
from widgets.common.step_titles import title_steps


class HistoryPanel(Panel):
    """Steps in force and, greyed, steps that were undone; a click goes there."""

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("history")
        self.setWindowTitle(self.tr("History"))
        self.list = QListWidget(self)
        self.list.setAccessibleName(self.tr("Steps of this session"))
        self.list.setAlternatingRowColors(True)
        self.list.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.note = QLabel(self)
        self.note.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.addWidget(self.list, 1)
        layout.addWidget(self.note)
        self._shown: tuple[object, ...] = ()
        # A click or the arrow keys: both go to the step.
        self.list.currentRowChanged.connect(self._on_row)

    def on_document(self, change: Change) -> None:
        """Computed fields are no steps."""
        if change.aspects != {"fields"}:
            super().on_document(change)

    def refresh(self) -> None:
        """List the steps as they are."""
        history = self.controller.project.history
        done, undone = history.done, history.undone
        with QSignalBlocker(self.list):
            shown = (*map(id, done), None, *map(id, undone))
            if shown != self._shown:
                self._shown = shown
                titles = [self.tr("Start"), *title_steps((*done, *undone))]
                self._list_steps(titles, len(done) + 1)
            self.list.setCurrentRow(len(done))
        self.list.scrollToItem(self.list.item(len(done)))
        on_disk = history.on_disk
        self.note.setText(
            self.tr("The way back of the oldest {n} steps lies on disk, to save memory.").format(
                n=show_count(on_disk)
            )
        )
        self.note.setVisible(on_disk > 0)

    def restyle(self) -> None:
        """Grey the undone steps anew."""
        self._shown = ()
        self.refresh_soon()

    def _list_steps(self, titles: list[str], done: int) -> None:
        self.list.clear()
        grey = self.palette().brush(QPalette.ColorRole.PlaceholderText)
        for number, title in enumerate(titles):
            item = QListWidgetItem(title)
            item.setToolTip(title)
            if number >= done:
                item.setForeground(grey)
                font = item.font()
                font.setItalic(True)
                item.setFont(font)
                item.setToolTip(self.tr("{step} (undone; click to do it again)").format(step=title))
            self.list.addItem(item)

    def _on_row(self, row: int) -> None:
        if row >= 0:
            self.controller.jump(row)
