"""The mesh of each leaf of the current scan."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace

from app.core.errors import BadInput, Cancelled, LeafscopeError, MissingScanner
from app.core.progress import Progress
from app.model.fields import Same
from app.model.leaf import Leaf
from app.model.project import Project
from app.model.state import ScanState
from app.services.leaves import Row
from app.services.surfaces.meshes import LeafSurface, mesh_leaves, tell_area
from app.services.surfaces.steep import turn_surfaces
from widgets.common.leaf_cache import LeafCache, mark_leaf
from widgets.controller import Then


class LeafAreas(LeafCache[LeafSurface]):
    """Surfaces of leaves.

    Attributes
    ----------
    by_intensity : bool
        The curve in use tells normals and angles of steep faces.
    """

    by_intensity = False

    def title(self) -> str:
        """What is being done."""
        return self.tr("Meshing leaves")

    def rows(self, leaves: tuple[Leaf, ...]) -> Mapping[str, Row]:
        """Columns of the areas that are known, by the key of the leaf."""
        return {key: tell_area(surface) for key, surface in self.results(leaves).items()}

    def mark(self, leaf: Leaf, state: ScanState) -> Hashable:
        """All that the surface of a leaf depends on."""
        parameters = state.parameters
        told = (parameters.curve, parameters.radiometry) if self.by_intensity else None
        return (
            mark_leaf(leaf, state), Same(state.marks), parameters.beam, parameters.ghost_threshold,
            told,
        )  # fmt: skip

    def prepare(self, scan: str, state: ScanState, leaves: list[Leaf], then: Then) -> None:
        """Ghosts are no part of a leaf."""
        self.controller.want(scan, "ghost", None, then, quiet=True)

    def compute(
        self, project: Project, scan: str, keys: list[str], progress: Progress
    ) -> dict[str, LeafSurface]:
        """Meshes; where a scan allows none, the reason."""
        try:
            surfaces = mesh_leaves(project, scan, keys, progress)
        except (BadInput, MissingScanner) as error:
            leaves = [project.state.leaves[key] for key in keys]
            surfaces = [LeafSurface(leaf.key, leaf.name, None, str(error)) for leaf in leaves]
        if self.by_intensity:
            try:
                surfaces = turn_surfaces(project, scan, surfaces, None, progress)
            except Cancelled:
                raise
            except LeafscopeError as error:
                surfaces = [replace(one, reason=one.reason or str(error)) for one in surfaces]
        return {surface.key: surface for surface in surfaces}
