"""What leaves the panel: the table of all leaves, and figures of them on white paper."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction, QGuiApplication
from PySide6.QtWidgets import QMenu

from app.core.progress import Progress
from app.services.leaves import Row
from app.services.wrinkles.measure import LeafWrinkles
from app.services.wrinkles.picture import draw_leaves
from app.services.wrinkles.run import TABLES, write_rows
from widgets.controller import Controller


class WrinkleExport(QObject):
    """Entries of a menu; the panel says what there is to write.

    Signals
    -------
    file_asked(str, str)
        A file shall be chosen: a word for its name, and its ending; `write` shall be called.
    """

    file_asked = Signal(str, str)

    def __init__(self, controller: Controller, menu: QMenu) -> None:
        super().__init__(menu)
        self._controller = controller
        self._rows: list[Row] = []
        self._leaf: LeafWrinkles | None = None
        self._every: tuple[LeafWrinkles, ...] = ()
        self._few = False
        self.tables = [
            self._add(menu, self.tr("Table as &CSV…"), "wrinkles", ".csv"),
            self._add(menu, self.tr("Table as &JSON…"), "wrinkles", ".json"),
        ]
        self.copy = menu.addAction(self.tr("Cop&y table"))
        self.copy.setToolTip(self.tr("For a spreadsheet"))
        self.copy.triggered.connect(self._copy)
        menu.addSeparator()
        self.figures = [
            self._add(menu, self.tr("This leaf as &PNG…"), "leaf", ".png"),
            self._add(menu, self.tr("This leaf as &SVG…"), "leaf", ".svg"),
            self._add(menu, self.tr("This leaf as P&DF…"), "leaf", ".pdf"),
        ]
        self.six = self._add(menu, self.tr("Six &largest leaves as PDF…"), "leaves", ".pdf")
        menu.setToolTipsVisible(True)
        self.offer((), None, ())

    def offer(
        self, rows: Sequence[Row], leaf: LeafWrinkles | None, every: Sequence[LeafWrinkles]
    ) -> None:
        """Say what there is to write: rows, the leaf that is shown, all leaves."""
        self._rows, self._leaf, self._every = list(rows), leaf, tuple(every)
        shown = leaf is not None and leaf.judged is not None and leaf.judged.spread is not None
        for action in (*self.tables, self.copy):
            action.setEnabled(bool(rows))
        for action in self.figures:
            action.setEnabled(shown)
        self.six.setEnabled(any(each.judged and each.judged.spread for each in every))

    def write(self, path: Path) -> None:
        """Write what was asked for last; the dialog has asked about a file that exists."""
        if path.suffix.lower() in TABLES:
            if self._controller.attempt(lambda: write_rows(self._rows, path, overwrite=True)):
                self._tell(path)
            return
        leaves = self._every if self._few else tuple(filter(None, (self._leaf,)))

        def work(_: Progress) -> None:
            draw_leaves(leaves, path, overwrite=True)

        self._controller.run(self.tr("Writing the figure"), work, partial(self._tell, path))

    def _add(self, menu: QMenu, title: str, word: str, suffix: str) -> QAction:
        action = menu.addAction(title)
        action.triggered.connect(partial(self._ask, word, suffix))
        return action

    def _ask(self, word: str, suffix: str, _: bool = False) -> None:
        self._few = word == "leaves"
        self.file_asked.emit(word, suffix)

    def _tell(self, path: Path, _: object = None) -> None:
        self._controller.said.emit(self.tr("Written to {0}.").format(path))

    def _copy(self) -> None:
        names = list(dict.fromkeys(name for row in self._rows for name in row))
        lines = [names, *([_cell(row.get(name)) for name in names] for row in self._rows)]
        QGuiApplication.clipboard().setText("\n".join("\t".join(line) for line in lines))
        self._controller.said.emit(self.tr("The table is on the clipboard."))


def _cell(value: object) -> str:
    return "" if value is None else str(value)
