"""Leaves: the table of all leaves of the scan, and what can be done with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QItemSelection, QItemSelectionModel, QSortFilterProxyModel, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QFileDialog,
    QGridLayout,
    QHeaderView,
    QPushButton,
    QTableView,
    QVBoxLayout,
)

from app.model.leaf import Leaf
from app.model.points import PointSet
from app.model.selection import Explicit
from app.services.leaves import Row, write_table
from app.services.surfaces.files import write_surfaces
from widgets.common.leaf_areas import LeafAreas
from widgets.common.leaf_measures import LeafMeasures
from widgets.common.leaf_split import LeafSplit
from widgets.common.leaf_table import SORT, LeafTable
from widgets.common.notice import Notice
from widgets.common.numbers import show_count
from widgets.common.panel import Panel


class LeavesPanel(Panel):
    """Leaves as objects: find, make, name, merge, remove, measure, export.

    Signals
    -------
    chosen(tuple)
        Keys of the selected leaves.
    """

    chosen = Signal(object)

    def build(self) -> None:
        """Make the parts of the panel."""
        self.setObjectName("leaves")
        self.setWindowTitle(self.tr("Leaves"))
        self.notice = Notice(self)
        self.model = LeafTable(self)
        self.measures = LeafMeasures(self.controller, self)
        self.areas = LeafAreas(self.controller, self)
        self.split = LeafSplit(self.controller, self.work, self)
        self._sorted = QSortFilterProxyModel(self)
        self._sorted.setSourceModel(self.model)
        self._sorted.setSortRole(SORT)
        self.table = QTableView(self)
        self.find_button = QPushButton(self.tr("&Find leaves"), self)
        self.new_button = QPushButton(self.tr("&New leaf"), self)
        self.merge_button = QPushButton(self.tr("&Merge"), self)
        self.split_button = QPushButton(self.tr("S&plit…"), self)
        self.remove_button = QPushButton(self.tr("&Remove"), self)
        self.select_button = QPushButton(self.tr("&Select points"), self)
        self.export_button = QPushButton(self.tr("&Export table…"), self)
        self.mesh_button = QPushButton(self.tr("Export mes&h…"), self)
        self.steep_box = QCheckBox(self.tr("Steep parts of meshes by &intensity"), self)
        self._dress()
        self._arrange()
        self._connect()

    def _dress(self) -> None:
        table = self.table
        table.setModel(self._sorted)
        table.setAccessibleName(self.tr("Leaves of the current scan"))
        table.setSortingEnabled(True)
        table.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        table.setAlternatingRowColors(True)
        table.setShowGrid(False)
        table.setWordWrap(False)
        table.verticalHeader().hide()
        header = table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setHighlightSections(False)
        for button, tip in (
            (self.find_button, self.tr("Split the scan into leaves where the surface jumps")),
            (self.new_button, self.tr("Make a leaf of the selection, or of the next lasso")),
            (self.merge_button, self.tr("Make one leaf of the selected ones")),
            (self.split_button, self.tr("Make several leaves of one by clicking a point on each")),
            (self.remove_button, self.tr("Remove the selected leaves; their points stay")),
            (self.select_button, self.tr("Make the points of the selected leaves the selection")),
            (self.export_button, self.tr("Write all numbers of this table to a CSV file")),
            (
                self.mesh_button,
                self.tr(
                    "Write the triangles of the selected leaves, or of all, as PLY, OBJ or STL"
                ),
            ),
        ):
            button.setToolTip(tip)
        self.steep_box.setToolTip(
            self.tr(
                "Normals and angles of faces beyond 60° from the curve in use (Phase lab), not "
                "from ranges; areas stay as they are"
            )
        )

    def _arrange(self) -> None:
        buttons = QGridLayout()
        for place, button in enumerate(
            (
                self.find_button,
                self.new_button,
                self.merge_button,
                self.split_button,
                self.remove_button,
                self.select_button,
                self.export_button,
                self.mesh_button,
            )
        ):
            buttons.addWidget(button, place // 2, place % 2)
        layout = QVBoxLayout(self)
        layout.addWidget(self.notice)
        layout.addWidget(self.table, 1)
        layout.addStretch(0)
        layout.addWidget(self.split)
        layout.addWidget(self.steep_box)
        layout.addLayout(buttons)

    def _connect(self) -> None:
        self.model.name_asked.connect(self.work.rename)
        self.measures.measured.connect(self.refresh_soon)
        self.areas.measured.connect(self.refresh_soon)
        self.table.selectionModel().selectionChanged.connect(self._on_selected)
        self.find_button.clicked.connect(self.work.find_all)
        self.new_button.clicked.connect(self.make_next)
        self.merge_button.clicked.connect(self.merge)
        self.split_button.clicked.connect(self.split_leaf)
        self.remove_button.clicked.connect(self.remove)
        self.select_button.clicked.connect(self.select_points)
        self.export_button.clicked.connect(self.ask_for_file)
        self.mesh_button.clicked.connect(self.ask_for_mesh)
        self.steep_box.toggled.connect(self.use_intensity)

    @property
    def leaves(self) -> tuple[Leaf, ...]:
        """Leaves of the current scan."""
        scan = self.controller.current
        return () if scan is None else self.controller.project.state.leaves_of(scan)

    @property
    def selected(self) -> tuple[str, ...]:
        """Keys of the selected leaves, in the order of the table."""
        rows = self.table.selectionModel().selectedRows()
        places = sorted(self._sorted.mapToSource(index).row() for index in rows)
        return tuple(self.model.leaves[place].key for place in places)

    def refresh(self) -> None:
        """Show the leaves; measure those that are new."""
        state, leaves = self.controller.scan, self.leaves
        self.notice.say(self._find_missing())
        self.table.setVisible(bool(leaves))
        kept = self.selected
        self.split.follow()
        self.measures.measure(leaves)
        self.areas.measure(leaves)
        channels = () if state is None else state.channels
        self.model.show_leaves(leaves, self._rows(), channels)
        self._select(kept)
        self._enable()

    def _rows(self) -> dict[str, Row]:
        """What is known of the leaves by now, with their areas where these are known."""
        measured, areas = self.measures.results(self.leaves), self.areas.rows(self.leaves)
        return {key: {**row, **areas.get(key, {})} for key, row in measured.items()}

    def _find_missing(self) -> str:
        state = self.controller.scan
        if state is None:
            return self.tr("Open a scan; its leaves will be listed here.")
        if not self.leaves:
            return self.tr(
                "No leaf yet. Press Find leaves, or draw a contour around one with the lasso."
            )
        if state.scan.pose is None:
            return self.tr("Angles are missing: nobody knows where the scanner stood.")
        return ""

    def _select(self, kept: tuple[str, ...]) -> None:
        """Keep the selection; the leaf that all panels work on is always part of it."""
        current = self.controller.view.leaf
        wanted = kept if current in kept or current is None else (current,)
        rows = [row for row in (self.model.find_row(key) for key in wanted) if row >= 0]
        if self.selected == tuple(wanted) or not rows:
            return
        chosen = QItemSelection()
        for row in rows:
            index = self._sorted.mapFromSource(self.model.index(row, 0))
            chosen.select(index, index)
        selection = self.table.selectionModel()
        flags = QItemSelectionModel.SelectionFlag
        selection.select(chosen, flags.ClearAndSelect | flags.Rows)
        self.table.scrollTo(self._sorted.mapFromSource(self.model.index(rows[0], 0)))

    def _enable(self) -> None:
        state, count = self.controller.scan, len(self.selected)
        self.find_button.setEnabled(state is not None)
        self.new_button.setEnabled(state is not None)
        self.merge_button.setEnabled(count > 1)
        self.split_button.setEnabled(count == 1)
        self.remove_button.setEnabled(count > 0)
        self.select_button.setEnabled(count > 0)
        measured = self.measures.results(self.leaves)
        self.export_button.setEnabled(bool(measured) and len(measured) == len(self.leaves))
        meshed = self.areas.results(self.leaves).values()
        self.mesh_button.setEnabled(any(surface.mesh is not None for surface in meshed))

    def make_next(self) -> None:
        """Make a leaf of the selection; without one the next lasso begins a new leaf."""
        scan, state = self.controller.current, self.controller.scan
        if scan is None or state is None:
            return
        points = state.selection
        if len(points):
            self.work.make_leaf(scan, points, Explicit(points))
        else:
            self.table.clearSelection()
            self.controller.look(leaf=None)
            self.controller.said.emit(self.tr("The next lasso makes a new leaf."))

    def merge(self) -> None:
        """Make one leaf of the selected ones."""
        keys = self.selected
        if len(keys) < 2:
            self.controller.said.emit(
                self.tr("Select two leaves or more in the table (Ctrl+click), then merge them.")
            )
            return
        self.work.merge(keys)
        self.controller.look(leaf=keys[0])

    def split_leaf(self) -> None:
        """Begin to split the selected leaf."""
        keys = self.selected
        if len(keys) == 1:
            self.split.start(self.controller.project.state.leaves[keys[0]])
        else:
            self.controller.said.emit(self.tr("Select the leaf to split in the table."))

    def remove(self) -> None:
        """Remove the selected leaves."""
        self.work.remove(self.selected)

    def select_points(self) -> None:
        """Make the points of the selected leaves the selection of the scan."""
        scan, leaves = self.controller.current, self.controller.project.state.leaves
        members = [leaves[key].members.indices for key in self.selected]
        if scan is not None and members:
            points = PointSet(np.concatenate(members))
            self.work.apply(scan, points, Explicit(points), "select")

    def ask_for_file(self) -> None:
        """Ask where to write the table; the dialog itself asks before it replaces a file."""
        dialog = QFileDialog(self, self.tr("Export the table of leaves"))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(self.tr("Tables (*.csv)"))
        dialog.setDefaultSuffix("csv")
        dialog.fileSelected.connect(self.export)
        dialog.open()

    def export(self, path: str) -> None:
        """Write the table with all its numbers; an existing file is replaced."""
        leaves, measured = self.leaves, self._rows()
        rows = [measured[leaf.key] | {"name": leaf.name} for leaf in leaves if leaf.key in measured]
        if self.controller.attempt(lambda: write_table(rows, Path(path), overwrite=True)):
            self.controller.said.emit(
                self.tr("{n} leaves written to {path}.").format(n=show_count(len(rows)), path=path)
            )

    def use_intensity(self, on: bool) -> None:
        """Let the curve in use tell normals of steep faces; without one, say so."""
        state = self.controller.scan
        if on and (state is None or state.parameters.curve is None):
            self.steep_box.setChecked(False)
            self.controller.said.emit(
                self.tr("Put a curve to use in the Phase lab first: it tells angles by intensity.")
            )
            return
        self.areas.by_intensity = on
        self.refresh_soon()
        self.areas.measured.emit()

    def ask_for_mesh(self) -> None:
        """Ask where to write the triangles; the dialog itself asks before it replaces a file."""
        if not self.mesh_button.isEnabled():
            self.controller.said.emit(self._tell_no_mesh())
            return
        dialog = QFileDialog(self, self.tr("Export the mesh of leaves"))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(self.tr("Triangles (*.ply *.obj *.stl)"))
        dialog.setDefaultSuffix("ply")
        dialog.fileSelected.connect(self.export_mesh)
        dialog.open()

    def _tell_no_mesh(self) -> str:
        """Why there is nothing to export."""
        if not self.leaves:
            return self.tr("No leaf yet: find leaves first, then export their mesh.")
        surfaces = self.areas.results(self.leaves)
        if len(surfaces) < len(self.leaves):
            return self.tr("The leaves are being meshed; export the mesh when that is done.")
        return next(iter(surfaces.values())).reason

    def export_mesh(self, path: str) -> None:
        """Write the triangles of the selected leaves, or of all; an existing file is replaced."""
        chosen = self.selected or tuple(leaf.key for leaf in self.leaves)
        meshed = self.areas.results(self.leaves)
        surfaces = [meshed[key] for key in chosen if key in meshed]
        told = self.tr("{n} leaves written to {path}.").format(
            n=show_count(sum(surface.mesh is not None for surface in surfaces)), path=path
        )
        self.controller.run(
            self.tr("Writing meshes"),
            lambda _: write_surfaces(surfaces, Path(path), overwrite=True),
            lambda _: self.controller.said.emit(told),
        )

    def _on_selected(self) -> None:
        keys = self.selected
        self._enable()
        self.chosen.emit(keys)
        if len(keys) == 1 and keys[0] != self.controller.view.leaf:
            self.controller.look(leaf=keys[0])
