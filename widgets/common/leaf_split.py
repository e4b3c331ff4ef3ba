"""Splitting a leaf by seeds: which points were given, and the buttons for it."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.leaf import Leaf
from app.model.points import PointSet
from widgets.controller import Controller
from widgets.leaf_work import LeafWork


class LeafSplit(QFrame):
    """Gathers seeds of one leaf: points that are clicked, and selections; hidden when idle.

    Signals
    -------
    pick_asked()
        The user wants to click points in the picture.
    changed()
        There are other seeds, or none.
    """

    pick_asked = Signal()
    changed = Signal()

    def __init__(self, controller: Controller, work: LeafWork, parent: QWidget) -> None:
        super().__init__(parent)
        self._controller, self._work = controller, work
        self.leaf: Leaf | None = None
        self.seeds: list[PointSet] = []
        self.setProperty("notice", "info")
        self.label = QLabel(self)
        self.label.setWordWrap(True)
        self.add_button = QPushButton(self.tr("Add selec&tion"), self)
        self.add_button.setToolTip(
            self.tr("Take the selected points of the leaf, a lasso's for one, as a further seed")
        )
        self.split_button = QPushButton(self.tr("Split no&w"), self)
        self.split_button.setToolTip(
            self.tr("Make a leaf around each seed; undo makes them one again")
        )
        self.split_button.setProperty("primary", "true")
        self.cancel_button = QPushButton(self.tr("&Cancel"), self)
        self.cancel_button.setToolTip(self.tr("Forget the seeds; the leaf stays as it is"))
        buttons = QHBoxLayout()
        for button in (self.split_button, self.add_button, self.cancel_button):
            buttons.addWidget(button, 0, Qt.AlignmentFlag.AlignLeft)
        buttons.addStretch(1)
        layout = QVBoxLayout(self)
        layout.addWidget(self.label)
        layout.addLayout(buttons)
        self.add_button.clicked.connect(self.add_selection)
        self.split_button.clicked.connect(self.split)
        self.cancel_button.clicked.connect(self.stop)
        self._show()

    def start(self, leaf: Leaf) -> None:
        """Begin to gather seeds of a leaf."""
        self.leaf, self.seeds = leaf, []
        self._controller.look(leaf=leaf.key)
        self._show()
        self.pick_asked.emit()

    def stop(self) -> None:
        """Forget the seeds."""
        if self.leaf is not None:
            self.leaf, self.seeds = None, []
            self._show()

    def follow(self) -> None:
        """Stop where the leaf is gone or other than it was."""
        leaf = self.leaf
        if leaf is None:
            return
        there = self._controller.project.state.leaves.get(leaf.key)
        if self._controller.current != leaf.scan or there is None or there.members != leaf.members:
            self.stop()
        else:
            self._show()

    def take_point(self, scan: str, row: int) -> None:
        """Take a clicked point as a further seed."""
        if self.leaf is not None:
            self._add(scan, PointSet([row]))

    def add_selection(self) -> None:
        """Take the selected points of the leaf as a further seed."""
        scan, state = self._controller.current, self._controller.scan
        if self.leaf is not None and scan is not None and state is not None:
            self._add(scan, state.selection)

    def split(self) -> None:
        """Make a leaf around each seed."""
        if self.leaf is not None and len(self.seeds) > 1:
            self._work.split(self.leaf.key, tuple(self.seeds))
            self.stop()

    def _add(self, scan: str, points: PointSet) -> None:
        if self.leaf is None:
            return
        own = points & self.leaf.members if scan == self.leaf.scan else PointSet()
        if not len(own):
            self._controller.said.emit(
                self.tr("That is no point of {leaf}.").format(leaf=self.leaf.name)
            )
        elif any(len(own & seed) for seed in self.seeds):
            self._controller.said.emit(self.tr("A seed lies there already."))
        else:
            self.seeds.append(own)
            self._show()

    def _show(self) -> None:
        leaf, count = self.leaf, len(self.seeds)
        self.setVisible(leaf is not None)
        self.split_button.setEnabled(count > 1)
        state = self._controller.scan
        self.add_button.setEnabled(state is not None and len(state.selection) > 0)
        if leaf is not None:
            text = self.tr(
                "Splitting {leaf}: click a point on each leaf that it holds, or lasso a part and "
                "add the selection. Seeds: {n}."
            ).format(leaf=leaf.name, n=count)
            self.label.setText(text)
            self.setAccessibleName(text)
        self.changed.emit()
