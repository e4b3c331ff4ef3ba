"""Footprints to be drawn: of selected points, of some points of a leaf, or of a scan."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress
from app.model.footprint_fields import require_beam
from app.model.neighbours import neighbours_of
from app.model.parameters import Beam
from app.model.points import EMPTY
from app.model.project import Project
from app.model.state import ScanState
from app.services.beams import propose_beam

MOST = 3000
"""Footprints that are drawn at a time: more are a blot."""
EVERY = 8
LOOKING = 0.3


def choose_rows(
    project: Project, scan: str, leaf: str | None, every: int = EVERY
) -> tuple[Ints, int]:
    """Selected points, and without a selection those of a leaf in every n-th row and column.

    Returns
    -------
    rows : (k,) int64
        At most `MOST`, all alive.
    every : int
        Rows and columns from one to the next: more than asked for where that were too many.

    Raises
    ------
    WrongUse
        `every` is below 1.
    """
    state = project.state.scan(scan)
    if len(state.selection):
        return thin(state, state.selection.indices, 1)
    known = project.state.leaves.get(leaf or "")
    here = known is not None and known.scan == scan
    members = known.members if known is not None and here else EMPTY
    return thin(state, members.indices, every)


def thin(state: ScanState, rows: Ints, every: int) -> tuple[Ints, int]:
    """Of some points those in every n-th row and column; see `choose_rows`.

    Without rows and columns, every n²-th point.
    """
    if every < 1:
        raise WrongUse(
            f"Footprints of every {every}th row and column cannot be drawn.", "Give 1 or more."
        )
    there, grid = rows[state.alive[rows]], state.scan.grid
    while True:
        taken = there[:: every * every]
        if grid is not None:
            lines = (grid.row[there] % every == 0) & (grid.column[there] % every == 0)
            taken = there[lines]
        if len(taken) <= MOST:
            return taken, every
        every += 1


def make_rings(state: ScanState, rows: Ints, progress: Progress = QUIET) -> Floats:
    """Footprints of points, on the local planes that the incidence angle rests on.

    Returns
    -------
    (k, corners, 3) array
        World metres; points without a plane, or so steep that the beam does not meet it, are
        left out.

    Raises
    ------
    BadInput
        Nobody told the beam.
    MissingScanner
        Nobody told where the scanner stood.
    Cancelled
    """
    from app.core.footprint_rings import footprint_rings
    from app.core.incidence import local_planes

    scan, parameters = state.scan, state.parameters
    scanner, beam = scan.scanner("the footprint"), find_beam(state)
    neighbours = neighbours_of(scan, progress.part(0.0, LOOKING))
    planes = local_planes(
        scan.xyz, scanner, rows, parameters.radius, neighbours.grid,
        progress.part(LOOKING, 1.0), parameters.estimator,
    )  # fmt: skip
    rings = footprint_rings(
        scan.xyz[rows], planes.normals, scanner, beam.radius, beam.half_divergence
    )
    return rings[np.isfinite(rings).all(axis=(1, 2))]


def find_beam(state: ScanState) -> Beam:
    """The beam of the parameters, else of the instrument that the scan names.

    Raises
    ------
    BadInput
        Nobody told it.
    """
    return require_beam(state.parameters.beam or propose_beam(state.scan))
