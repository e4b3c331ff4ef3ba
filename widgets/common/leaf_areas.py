"""Keeps the mesh of each leaf, and has only those made again that changed."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

from PySide6.QtCore import QObject, Signal

from app.core.errors import BadInput, MissingScanner
from app.core.progress import Progress
from app.model.fields import Same
from app.model.leaf import Leaf
from app.model.state import ScanState
from app.services.leaves import Row
from app.services.surfaces.meshes import LeafSurface, mesh_leaves, tell_area
from widgets.common.aside import copy_aside
from widgets.controller import Controller


class LeafAreas(QObject):
    """Surfaces of leaves of the current scan, made in the background.

    Signals
    -------
    measured()
        There are new surfaces.
    """

    measured = Signal()

    def __init__(self, controller: Controller, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._surfaces: dict[str, tuple[Hashable, LeafSurface]] = {}
        self._asked: dict[str, Hashable] = {}

    def surfaces(self, leaves: tuple[Leaf, ...]) -> Mapping[str, LeafSurface]:
        """Surfaces that are still valid, by the key of the leaf."""
        state = self._controller.scan
        if state is None:
            return {}
        held = ((leaf, self._surfaces.get(leaf.key)) for leaf in leaves)
        return {
            leaf.key: found[1]
            for leaf, found in held
            if found is not None and found[0] == _mark(leaf, state)
        }

    def rows(self, leaves: tuple[Leaf, ...]) -> Mapping[str, Row]:
        """Columns of the areas that are known, by the key of the leaf."""
        return {key: tell_area(surface) for key, surface in self.surfaces(leaves).items()}

    def measure(self, leaves: tuple[Leaf, ...]) -> None:
        """Mesh in the background what is new or changed, and only that."""
        there = self._controller.project.state.leaves
        self._surfaces = {key: one for key, one in self._surfaces.items() if key in there}
        self._asked = {key: mark for key, mark in self._asked.items() if key in there}
        scan, state = self._controller.current, self._controller.scan
        if scan is None or state is None:
            return
        marks = {leaf.key: _mark(leaf, state) for leaf in leaves}
        valid = self.surfaces(leaves)
        wanted = {
            key: mark
            for key, mark in marks.items()
            if key not in valid and self._asked.get(key) != mark
        }
        if not wanted:
            return
        self._asked.update(wanted)
        if state.scan.pose is None:
            self._run(scan, wanted)
            return

        def then() -> None:
            self._run(scan, wanted)

        self._controller.want(scan, "ghost", None, then, quiet=True)

    def _run(self, scan: str, marks: Mapping[str, Hashable]) -> None:
        aside = copy_aside(self._controller.project, scan)
        leaves = [leaf for leaf in aside.state.leaves_of(scan) if leaf.key in marks]

        def work(progress: Progress) -> list[LeafSurface]:
            try:
                return mesh_leaves(aside, scan, list(marks), progress)
            except (BadInput, MissingScanner) as error:
                return [LeafSurface(leaf.key, leaf.name, None, str(error)) for leaf in leaves]

        def done(surfaces: list[LeafSurface]) -> None:
            for surface in surfaces:
                self._surfaces[surface.key] = (marks[surface.key], surface)
            self.measured.emit()

        self._controller.run(self.tr("Meshing leaves"), work, done)


def _mark(leaf: Leaf, state: ScanState) -> Hashable:
    """All that the surface of a leaf depends on."""
    parameters = state.parameters
    return (
        leaf.scan,
        Same(leaf.members),
        Same(state.scan.xyz),
        state.scan.pose,
        Same(state.deleted),
        Same(state.marks),
        parameters.beam,
        parameters.ghost_threshold,
    )
