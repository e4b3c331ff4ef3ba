"""The mesh of the current leaf in the 3-D view, while it is wished for."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer

from app.core.units import to_degrees
from app.model.leaf import Leaf
from app.services.surfaces.meshes import LeafSurface
from widgets.common.leaf_areas import LeafAreas
from widgets.common.numbers import show_count, show_number
from widgets.controller import Controller
from widgets.picture import Picture

CM2_PER_M2 = 1e4


class MeshOverlay(QObject):
    """Follows the leaf, what its mesh rests on, and the wish of the view."""

    def __init__(
        self, controller: Controller, picture: Picture, areas: LeafAreas, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._controller, self._picture, self._areas = controller, picture, areas
        self.shown: LeafSurface | None = None
        self._invited = False
        # Many changes of one turn are one change.
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._follow)
        for signal in (controller.document_changed, controller.view_changed, areas.measured):
            signal.connect(self._follow_soon)

    def stop(self) -> None:
        """Look no more; the window calls it before the picture goes."""
        self._later.stop()
        for signal in (
            self._controller.document_changed,
            self._controller.view_changed,
            self._areas.measured,
        ):
            signal.disconnect(self._follow_soon)

    def _follow_soon(self, *_: object) -> None:
        self._later.start()

    def _follow(self) -> None:
        leaf = self._find_leaf()
        if leaf is None:
            self._show(None)
            self._invite()
            return
        self._invited = False
        self._areas.measure((leaf,))
        self._show(self._areas.results((leaf,)).get(leaf.key))

    def _find_leaf(self) -> Leaf | None:
        """The leaf whose mesh is wished for; None: none."""
        view, scan = self._controller.view, self._controller.current
        if not view.show_mesh or scan is None or scan in view.hidden:
            return None
        leaf = self._controller.project.state.leaves.get(view.leaf or "")
        return leaf if leaf is not None and leaf.scan == scan else None

    def _invite(self) -> None:
        """Say once what is missing."""
        wished = self._controller.view.show_mesh and self._controller.current is not None
        if wished and not self._invited:
            self._controller.said.emit(self.tr("Choose a leaf in Leaves to see its mesh."))
        self._invited = wished

    def _show(self, surface: LeafSurface | None) -> None:
        if surface is self.shown:
            return
        self.shown = surface
        mesh = None if surface is None else surface.mesh
        view = self._picture.view
        if view is not None:
            triangles = None
            if mesh is not None:
                triangles = (mesh.vertices, mesh.faces, to_degrees(mesh.omega))
            view.drawings.show_mesh(triangles)
        if surface is not None:
            self._controller.said.emit(self._tell(surface))

    def _tell(self, surface: LeafSurface) -> str:
        if surface.mesh is None:
            return f"{surface.name}: {surface.reason}"
        area = surface.mesh.area
        text = (
            self.tr("{name}: {n} triangles, {area} cm² ({low} to {high})")
            if area.sure
            else self.tr("{name}: {n} triangles, visible {area} cm²; the leaf is at least as large")
        )
        value, low, high = (
            show_number(a * CM2_PER_M2, 1) for a in (area.value, area.low, area.high)
        )
        count = show_count(len(surface.mesh.faces))
        told = text.format(name=surface.name, n=count, area=value, low=low, high=high)
        return f"{told}. {surface.reason}" if surface.reason else told
