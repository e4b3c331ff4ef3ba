"""What the Edit and Scan menus do to points and scans."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from app.model.operations import Select, SetDeleted
from app.model.points import PointSet
from app.model.scan import Pose
from app.model.selection import Complement, Explicit
from widgets.controller import Controller
from widgets.dialogs.channel import ChannelDialog
from widgets.dialogs.origin import OriginDialog
from widgets.dialogs.text_layout import TextLayoutDialog
from widgets.documents import Documents
from widgets.leaf_work import LeafWork
from widgets.tools import Tools

if TYPE_CHECKING:
    from widgets.panels.leaves import LeavesPanel


class ScanDeeds(QObject):
    """Selection, deletion, leaves, and what a scan has to be told."""

    def __init__(
        self,
        window: QWidget,
        controller: Controller,
        documents: Documents,
        work: LeafWork,
        tools: Tools,
    ) -> None:
        super().__init__(window)
        self._window, self._controller, self._documents = window, controller, documents
        self._work, self._tools = work, tools
        self._leaves: LeavesPanel | None = None

    def serve(self, leaves: LeavesPanel) -> None:
        """Take the panel of leaves into service: it knows which of them are chosen."""
        self._leaves = leaves

    def invert_selection(self) -> None:
        """Select what is not selected."""
        key, state = self._controller.current, self._controller.scan
        if key is not None and state is not None:
            rest = PointSet.from_mask(state.alive & ~state.selection.mask(len(state.scan)))
            self._controller.do(Select(key, rest, Complement(Explicit(state.selection))))

    def clear_selection(self) -> None:
        """Select nothing."""
        self._work.clear_selection()

    def delete_selection(self) -> None:
        """Delete the selected points, and let go of them."""
        key, state = self._controller.current, self._controller.scan
        if key is not None and state is not None and len(state.selection):
            points = state.selection
            self._work.apply(key, points, Explicit(points), "delete")

    def bring_back(self) -> None:
        """Bring all deleted points back."""
        key, state = self._controller.current, self._controller.scan
        if key is not None and state is not None:
            self._controller.do(SetDeleted(key, PointSet.from_mask(state.deleted), False))

    def make_leaf(self) -> None:
        """Make a leaf of the selection."""
        key, state = self._controller.current, self._controller.scan
        if key is not None and state is not None and len(state.selection):
            self._work.make_leaf(key, state.selection, Explicit(state.selection))

    def next_leaf(self) -> None:
        """Begin a fresh leaf: the next lasso makes one."""
        self._controller.look(leaf=None)
        self._tools.use_lasso_to("leaf")
        self._controller.said.emit(self.tr("Draw around the next leaf; Shift adds to it."))

    def find_leaves(self) -> None:
        """Segment the scan into leaves."""
        self._work.find_all()

    def split_leaf(self) -> None:
        """Begin to split the chosen leaf by seeds."""
        if self._leaves is not None:
            self._leaves.split_leaf()

    def merge_leaves(self) -> None:
        """Make one leaf of the chosen ones."""
        if self._leaves is not None:
            self._leaves.merge()

    def export_mesh(self) -> None:
        """Ask where to write the triangles of leaves."""
        if self._leaves is not None:
            self._leaves.ask_for_mesh()

    def set_origin(self, proposed: Pose | None = None) -> None:
        """Ask where the scanner stood."""
        if self._controller.current is not None:
            dialog = OriginDialog(self._controller, self._documents, proposed, self._window)
            dialog.open()

    def name_columns(self) -> None:
        """Ask how the text file of the current scan is to be read."""
        key, state = self._controller.current, self._controller.scan
        if key is None or state is None or state.scan.source is None:
            return
        dialog = TextLayoutDialog(Path(state.scan.source.path), self._window)
        dialog.chosen.connect(partial(self._documents.reopen, key))
        dialog.open()

    def name_columns_of(self, path: Path) -> None:
        """Ask how a text file that could not be opened is to be read."""
        dialog = TextLayoutDialog(path, self._window)
        dialog.chosen.connect(partial(self._documents.open, [path]))
        dialog.open()

    def write_indices(self) -> None:
        """Ask for indices of the user's own."""
        from widgets.dialogs.formulas import FormulasDialog

        if self._controller.current is not None:
            FormulasDialog(self._controller, self._window).open()

    def name_channel(self, channel: str = "") -> None:
        """Ask which attribute is an intensity, at which wavelength; `channel` comes first."""
        if self._controller.current is not None:
            dialog = ChannelDialog(self._controller, self._window)
            dialog.show_channel(channel)
            dialog.open()
