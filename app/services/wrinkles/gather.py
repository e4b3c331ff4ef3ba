"""What was measured of the leaves of a scan, as they are judged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.footprint import footprint_axis
from app.core.progress import QUIET, Progress
from app.core.radiometry.marks import SATURATED
from app.core.radiometry.partial_hits import FULL_HIT
from app.core.synthetic_footprint import Lines, find_lines
from app.core.wrinkling.leaf import LeafPoints
from app.core.wrinkling.means import cut_grid
from app.model.hit_fields import find_missing
from app.model.leaf import Leaf, join_members
from app.model.neighbours import neighbours_of
from app.model.project import Project
from app.model.radiometry_fields import MARK
from app.model.scan import Channel
from app.model.state import ScanState

STEPS_WIDE = 3.0
"""Where the beam is unknown, means reach over so many steps between points."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """Leaves of a scan with their points.

    Attributes
    ----------
    leaves : tuple of Leaf
    points : tuple of (k,) numbers
        Living points of each.
    measured : tuple of LeafPoints
    warnings : tuple of str
    """

    leaves: tuple[Leaf, ...]
    points: tuple[Ints, ...]
    measured: tuple[LeafPoints, ...]
    warnings: tuple[str, ...]

    def __iter__(self) -> Iterator[tuple[Leaf, Ints, LeafPoints]]:
        return iter(zip(self.leaves, self.points, self.measured, strict=True))


def gather_leaves(
    project: Project,
    scan: str,
    keys: Sequence[str] | None,
    channel: Channel,
    saturated: float | None,
    progress: Progress = QUIET,
) -> Gathered:
    """Read what is needed of the leaves named, or of all.

    Ghosts are those that the field ``ghost`` tells: the user's marks, else score and threshold.

    Raises
    ------
    MissingScanner, BadInput
        The scanner's position is unknown, or the channel cannot be had.
    """
    state = project.state.scan(scan)
    scanner = state.scan.scanner("Δω")
    leaves = [leaf for leaf in project.state.leaves_of(scan) if keys is None or leaf.key in keys]
    if not leaves:
        return Gathered((), (), (), ())
    every = join_members(leaves, len(state.scan))
    every = every[state.alive[every]]
    values = project.field(scan, channel.name, every, progress.part(0.0, 0.4))
    full, warnings = _find_full(project, scan, state, every, progress.part(0.4, 0.7))
    ghosts = project.field(scan, "ghost", every, progress.part(0.7, 0.9)) == 1.0
    ended = _find_saturated(project, scan, state, channel, every, values, saturated)
    grid = neighbours_of(state.scan, progress).grid
    lines = find_lines(state.scan.xyz, scanner, grid)
    if lines is None:
        warnings = (*warnings, "No rows and columns: footprints are looked up beam by beam.")
    points, measured = [], []
    for leaf in leaves:
        own = leaf.members.indices[state.alive[leaf.members.indices]]
        inside = np.searchsorted(every, own)
        cells, part = (None, None)
        if lines is not None and grid is not None and len(own):
            cells, part = cut_grid(grid, lines, own)
        xyz = state.scan.xyz[own]
        points.append(own)
        measured.append(LeafPoints(
            values[inside], xyz, scanner, find_diameter(state, xyz, scanner, part),
            None if full is None else full[inside], ended[inside], cells, part,
            ghosts[inside],
        ))  # fmt: skip
    return Gathered(tuple(leaves), tuple(points), tuple(measured), warnings)


def _find_full(
    project: Project, scan: str, state: ScanState, points: Ints, progress: Progress
) -> tuple[Bools | None, tuple[str, ...]]:
    missing = find_missing(state, progress)
    if missing:
        return None, (
            f"Points that the beam hits in part were not left out: {missing}. Borders look "
            "steeper than they are.",
        )
    share = project.field(scan, "hit_fraction", points, progress)
    return share >= FULL_HIT, ()


def _find_saturated(
    project: Project, scan: str, state: ScanState, channel: Channel, points: Ints,
    values: Floats, level: float | None,
) -> Bools:  # fmt: skip
    found = np.zeros(len(points), bool)
    if channel.calibration and channel not in state.scan.channels and not channel.workflow:
        found |= project.field(scan, channel.name + MARK, points) == SATURATED
    if level is not None:
        with np.errstate(invalid="ignore"):
            found |= values >= level
    return found


def find_diameter(state: ScanState, xyz: Floats, scanner: AnyArray, lines: Lines | None) -> float:
    """Diameter of the beam at a leaf, metres; three steps where the beam is unknown."""
    finite = xyz[np.isfinite(xyz).all(axis=1)]
    if not len(finite):
        return 1e-3
    away = float(np.median(np.linalg.norm(finite - scanner, axis=1)))
    beam = state.parameters.beam
    if beam is not None:
        return float(footprint_axis(away, 0.0, beam.radius, beam.half_divergence))
    if lines is not None and len(lines.elevation) > 1:
        return float(STEPS_WIDE * away * np.median(np.abs(np.diff(lines.elevation))))
    if len(finite) < 2:
        return 1e-3
    from scipy.spatial import cKDTree

    apart = np.asarray(cKDTree(finite).query(finite, k=2)[0])[:, 1]
    return STEPS_WIDE * float(np.median(apart))
