"""Meshes of a scan's leaves, with their areas: what the table, the files and the window show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Ints
from app.core.errors import BadInput, MissingScanner
from app.core.mesh import Mesh, estimate_beam, mesh_leaf
from app.core.neighbours.steps import UnusableGrid, as_cells, measure_steps
from app.core.progress import QUIET, Progress
from app.core.surfaces.crop import Layout, lay_out
from app.core.units import MM_PER_M, to_degrees
from app.model.leaf import Leaf
from app.model.neighbours import neighbours_of
from app.model.project import Project
from app.services.surfaces.echoes import find_echo

Cell = str | float | int | None
CM2_PER_M2 = 1e4


@dataclass(frozen=True, slots=True, eq=False)
class LeafSurface:
    """A leaf and its mesh; the reason tells why it has none, or none of what was asked for."""

    key: str
    name: str
    mesh: Mesh | None
    reason: str = ""


def mesh_leaves(
    project: Project, scan: str, keys: Sequence[str] | None = None, progress: Progress = QUIET
) -> list[LeafSurface]:
    """Mesh leaves of a scan, all of them unless `keys` names some.

    Deleted points and ghosts are no part of a leaf; what was deleted around it is taken for
    points between surfaces.

    Raises
    ------
    BadInput
        The scan has no rows and columns.
    MissingScanner, Cancelled
    """
    every = project.state.leaves_of(scan)
    leaves = [leaf for leaf in every if keys is None or leaf.key in keys]
    if not leaves:
        return []
    layout = lay_out_scan(project, scan, progress.part(0.0, 0.1))
    ghosts = find_left_out(project, scan, progress.part(0.1, 0.3))

    def members_of(leaf: Leaf) -> Ints:
        return leaf.members.indices[~ghosts[leaf.members.indices]]

    beam = project.state.scan(scan).parameters.beam
    known = None if beam is None else (beam.radius, beam.half_divergence)
    if known is None:
        progress.report(0.3, "Estimating the beam")
        # From all leaves, so that a leaf has one area whichever others are asked for.
        known = estimate_beam(layout, map(members_of, every), ghosts)
    found = []
    for place, leaf in enumerate(leaves):
        progress.report(0.4 + 0.6 * place / len(leaves), "Meshing leaves")
        try:
            mesh = mesh_leaf(layout, members_of(leaf), ghosts, known, beam is not None)
        except (BadInput, UnusableGrid) as error:
            found.append(LeafSurface(leaf.key, leaf.name, None, str(error)))
        else:
            found.append(LeafSurface(leaf.key, leaf.name, mesh))
    return found


def lay_out_scan(project: Project, scan: str, progress: Progress = QUIET) -> Layout:
    """The scan's points by cell; raises as `mesh_leaves` does."""
    source = project.state.scan(scan).scan
    scanner = source.scanner("the area of leaves")
    neighbours = neighbours_of(source, progress)
    if neighbours.grid is None:
        raise BadInput(
            f"{source.name}: a mesh needs rows and columns, and there are none: "
            f"{neighbours.reason}.",
            "Open the scan in a format that keeps them, such as PTX or E57.",
        )
    cells = as_cells(neighbours.grid)
    try:
        seam = measure_steps(source.xyz, scanner, cells).seam
        return lay_out(source.xyz, scanner, cells, seam, *find_echo(source))
    except UnusableGrid as error:
        raise BadInput(f"{source.name}: a mesh needs rows and columns, and {error}.") from error


def find_left_out(project: Project, scan: str, progress: Progress = QUIET) -> Bools:
    """Points that tell no border: deleted ones, ghosts, and those that were judged none, (n,).

    Ghosts that were put back on a surface are among the last: where a leaf ends is told by where
    they were.
    """
    state = project.state.scan(scan)
    ghost = project.field(scan, "ghost", None, progress)
    left_out: Bools = state.deleted | (ghost == 1.0) | (state.marks < 0)
    return left_out


def tell_area(surface: LeafSurface) -> dict[str, Cell]:
    """Columns of a table for one leaf: the area, its interval, and what it stands for."""
    if surface.mesh is None:
        return {**dict.fromkeys(COLUMNS), "area_of": surface.reason}
    area, mesh = surface.mesh.area, surface.mesh
    what = "leaf" if area.whole else "visible part, lower bound"
    if area.steep:
        what = f"seen nearly edge-on ({to_degrees(area.omega):.0f}°), lower bound"
    return {
        "area_cm2": area.value * CM2_PER_M2,
        "area_low_cm2": area.low * CM2_PER_M2,
        "area_high_cm2": None if area.steep else area.high * CM2_PER_M2,
        "area_of": what,
        "hidden_border": area.hidden,
        "beam_radius_mm": mesh.radius * MM_PER_M if np.isfinite(mesh.radius) else None,
        "beam": "known" if mesh.told else "estimated",
    }


COLUMNS = (
    "area_cm2", "area_low_cm2", "area_high_cm2", "area_of", "hidden_border", "beam_radius_mm",
    "beam",
)  # fmt: skip


def measure_areas(
    project: Project, scan: str, leaves: Sequence[Leaf], progress: Progress = QUIET
) -> dict[str, dict[str, Cell]]:
    """Columns of areas by leaf; where a scan allows no mesh, `area_of` says why."""
    try:
        surfaces = mesh_leaves(project, scan, [leaf.key for leaf in leaves], progress)
    except (BadInput, MissingScanner) as error:
        return {leaf.key: {**dict.fromkeys(COLUMNS), "area_of": str(error)} for leaf in leaves}
    return {surface.key: tell_area(surface) for surface in surfaces}
