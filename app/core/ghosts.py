"""Ghost points: how likely a point lies between two surfaces, and where it belongs.

A beam that touches two surfaces reports a range between, or just beyond, them (Balduzzi 2011;
mixed pixels). Such a point continues no surface around it.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import CHUNK, run_in_pieces, split_evenly
from app.core.incidence import RADIUS, local_planes
from app.core.neighbours.asked import as_points, each_once, slots_of
from app.core.neighbours.grid import SortedGrid, sort_grid
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid
from app.core.progress import QUIET, Progress

THRESHOLD = 0.7
HALF_WINDOW = 2
"""Cells on either side that may support a point."""
LEAST_GATE, LARGEST_GATE = 0.002, 0.012
GATE_IN_SIGMAS = 3.0
JUMP = 0.006
GRAZING_FROM = np.pi / 3
EVIDENCE = 0.05
"""Weight of grazing incidence, and of lost intensity, beside missing support. It orders points
of equal support; on two scenes with truth, more weight called more good points ghosts."""
FULL_SURFACE = 0.6
"""Share of the median density that a surface at 53° still holds."""
SAMPLE = 400
CORRECTION_WINDOW = 6
SURFACE_GAP = 0.010
LEAST_MEMBERS = 5


def ghost_score(
    xyz: Floats, scanner: AnyArray, points: Ints | None = None, grid: ScanGrid | None = None, *,
    incidence: Floats | None = None, intensity: AnyArray | None = None, radius: float = RADIUS,
    progress: Progress = QUIET,
) -> Floats:  # fmt: skip
    """Score points from 0 (lies on a surface) to 1 (ghost).

    On a scan grid: the share of the 24 beams around a point that do *not* continue its
    surface. One does when its range differs by no more than the noise allows, or when it
    lies in line with the point and the next beam beyond (a steep surface). Points with no
    jump around them score 0. Grazing incidence and lost intensity raise the score a little.

    Without a grid: points per ball against the density expected at that range, a weaker
    score, since it takes a thin or steep part for a ghost more easily.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    points : (k,) or None
        Numbers of the points asked for; None means all.
    grid : ScanGrid or None
    incidence : (k,) radians or None
    intensity : (n,) or None
        Proportional to the power received; any unit.
    radius : float
        Metres: the ball of the score without a grid.
    progress : Progress

    Returns
    -------
    (k,) float
        NaN for points without coordinates or range. Above `THRESHOLD`: a ghost.

    Raises
    ------
    BadInput, WrongUse, Cancelled
        See `app.core.incidence.local_planes`.
    """
    xyz = as_points(xyz)
    scanner = np.array(scanner, dtype=np.float64)
    share = np.full(len(xyz) if points is None else len(points), np.nan)
    try:
        if grid is None:
            raise UnusableGrid("the scan has no rows and columns")
        score, share = _score_on_grid(xyz, scanner, points, grid, intensity, progress)
    except UnusableGrid:
        score = _score_by_density(xyz, scanner, points, radius, progress)
    doubt = 1.0 - EVIDENCE * np.nan_to_num(np.clip((1.0 - share) / 0.4, 0.0, 1.0))
    if incidence is not None:
        grazing = (incidence - GRAZING_FROM) / (np.pi / 2 - GRAZING_FROM)
        doubt *= 1.0 - EVIDENCE * np.nan_to_num(np.clip(grazing, 0.0, 1.0))
    return np.where(score > 0.0, 1.0 - (1.0 - score) * doubt, score)


def _score_on_grid(
    xyz: Floats, scanner: Floats, points: Ints | None, grid: ScanGrid,
    intensity: AnyArray | None, progress: Progress,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Scores from support, and intensity as a share of that around (NaN: unknown)."""
    from app.core.kernels.ghosts import score_support

    asked, where = each_once(points, len(xyz))
    index = sort_grid(xyz, scanner, grid, asked, np.empty(0), least=2 * HALF_WINDOW)
    distance = _distances(index, scanner)
    slot = slots_of(asked, len(xyz))
    size = len(xyz) if asked is None else len(asked)
    score, share = np.full(size, np.nan), np.full(size, np.nan)
    light = as_points(np.empty(0) if intensity is None else intensity)
    gate = float(np.clip(GATE_IN_SIGMAS * index.steps.noise, LEAST_GATE, LARGEST_GATE))

    def work(first: int, last: int) -> None:
        score_support(
            distance, index.member, index.start, index.grid.row, index.grid.column, slot,
            first, last, index.steps.down, index.steps.across, index.steps.seam, light,
            HALF_WINDOW, gate, JUMP, score, share,
        )  # fmt: skip

    run_in_pieces(work, split_evenly(len(index.member)), progress, "ghost score")
    return score[where], share[where]


def _distances(index: SortedGrid, scanner: Floats) -> Floats:
    """Range of each sorted point, metres."""
    square = (index.x - scanner[0]) ** 2
    square += (index.y - scanner[1]) ** 2
    square += (index.z - scanner[2]) ** 2
    distance: Floats = np.sqrt(square, out=square)
    return distance


def _score_by_density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress
) -> Floats:
    """One minus the density in the ball, as a share of the median at equal range."""
    # The median must not depend on which points are asked for.
    sample = np.unique(np.linspace(0, len(xyz) - 1, min(len(xyz), SAMPLE)).astype(np.int64))
    usual = _density(xyz, scanner, sample, radius, QUIET)
    density = _density(xyz, scanner, points, radius, progress)
    if not np.isfinite(usual).any():
        return np.full(len(density), np.nan)
    return np.clip(1.0 - density / (FULL_SURFACE * np.nanmedian(usual)), 0.0, 1.0)


def _density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress
) -> Floats:
    """Points per area of the ball, times the range squared; NaN without a range."""
    planes = local_planes(xyz, scanner, points, radius, None, progress)
    asked = xyz if points is None else xyz[points]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        density: Floats = planes.count / planes.width**2 * ((asked - scanner) ** 2).sum(axis=1)
    return density


def correct_ghosts(
    xyz: Floats, scanner: AnyArray, ghosts: Ints, grid: ScanGrid | None = None, *,
    radius: float = RADIUS, progress: Progress = QUIET,
) -> tuple[Floats, Bools]:  # fmt: skip
    """Put ghosts back, along their beams, on the surface that dominates them.

    Of the surfaces around, that is the one nearest in range: the surface with most of the
    energy draws the mixed range to itself. Neighbours that touch a ghost's cell lie on the
    same border and are left out.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    ghosts : (g,)
        Numbers of the ghosts; they support nothing.
    grid : ScanGrid or None
        Neighbours come from the window of 13 × 13 beams, or else from a cone that is `radius`
        wide at the ghost.
    radius : float
        Metres.
    progress : Progress

    Returns
    -------
    moved : (g, 3) metres
    corrected : (g,) bool
        False, and not moved, where fewer than five points form a surface.

    Raises
    ------
    BadInput, Cancelled
    """
    from app.core.kernels.ghosts import dominant_ranges

    xyz = as_points(xyz)
    scanner = np.array(scanner, dtype=np.float64)
    ghosts = np.array(ghosts, dtype=np.int64)
    each_once(ghosts, len(xyz))
    full = _has_range(xyz, scanner)
    seen = full[ghosts]
    full[ghosts] = False
    look = _Surroundings(xyz, scanner, ghosts[seen], full, grid, radius)
    ranges = np.full(len(ghosts), np.nan)
    places = np.flatnonzero(seen)

    def work(first: int, last: int) -> None:
        part = ghosts[places[first:last]]
        borders, found = look.around(part)
        ranges[places[first:last]] = dominant_ranges(
            xyz, scanner, part, borders, found, SURFACE_GAP, LEAST_MEMBERS
        )

    run_in_pieces(work, split_evenly(len(places), CHUNK // 4), progress, "ghost correction")
    return _move_along_beams(xyz[ghosts], scanner, ranges), np.isfinite(ranges)


def _has_range(xyz: Floats, scanner: Floats) -> Bools:
    """Points with a finite range above zero, (n,)."""
    with np.errstate(invalid="ignore", over="ignore"):
        square = ((xyz - scanner) ** 2).sum(axis=1)
    usable: Bools = np.isfinite(square) & (square > 0.0)
    return usable


def _move_along_beams(points: Floats, scanner: Floats, ranges: Floats) -> Floats:
    """The points at new ranges; those whose range is NaN stay."""
    moved = points.copy()
    known = np.isfinite(ranges)
    beams = points[known] - scanner
    factor = ranges[known] / np.linalg.norm(beams, axis=1)
    moved[known] = scanner + beams * factor[:, None]
    return moved


@cache
def warm_up() -> None:
    """Compile, or load, the kernels once, so that no measured second holds it."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:4, :4])
    xyz = np.stack([np.ones(16), column / 1000.0, row / 1000.0], axis=1)
    cells = Cells(4, 4, row, column)
    ghost_score(xyz, np.zeros(3), np.arange(3), cells)
    correct_ghosts(xyz, np.zeros(3), np.arange(3), cells)


class _Surroundings:
    """Full points seen in nearly the same direction as a ghost."""

    def __init__(
        self, xyz: Floats, scanner: Floats, ghosts: Ints, full: Bools,
        grid: ScanGrid | None, radius: float,
    ) -> None:  # fmt: skip
        self.xyz, self.scanner, self.full, self.radius = xyz, scanner, full, radius
        self.index: SortedGrid | None = None
        if grid is not None:
            try:
                self.index = sort_grid(
                    xyz, scanner, grid, ghosts, np.empty(0), least=CORRECTION_WINDOW
                )
            except UnusableGrid:
                self.index = None
        if self.index is None:
            self._plant_tree()
        else:
            self._keep_off(self.index, ghosts)

    def _keep_off(self, index: SortedGrid, ghosts: Ints) -> None:
        from app.core.kernels.ghosts import drop_touched

        grid = index.grid
        drop_touched(
            index.member, index.start, grid.row, grid.column, ghosts,
            grid.rows, grid.columns, index.steps.seam, self.full,
        )  # fmt: skip

    def _plant_tree(self) -> None:
        from scipy.spatial import cKDTree

        self.members = np.flatnonzero(self.full)
        self.tree = cKDTree(self._directions(self.members))

    def _directions(self, points: Ints) -> Floats:
        beams = self.xyz[points] - self.scanner
        directions: Floats = beams / np.linalg.norm(beams, axis=1)[:, None]
        return directions

    def around(self, ghosts: Ints) -> tuple[Ints, Ints]:
        """Borders of each ghost's list, (g + 1,), and the lists of point numbers."""
        from app.core.kernels.ghosts import collect_windows

        if self.index is not None:
            grid = self.index.grid
            borders, found = collect_windows(
                self.index.member, self.index.start, grid.row, grid.column, ghosts,
                grid.rows, grid.columns, self.index.steps.seam, CORRECTION_WINDOW, self.full,
            )  # fmt: skip
            return borders, found
        cone = self.radius / np.linalg.norm(self.xyz[ghosts] - self.scanner, axis=1)
        lists = self.tree.query_ball_point(self._directions(ghosts), np.minimum(cone, 0.1))
        borders = np.append(0, np.cumsum([len(one) for one in lists]))
        found = self.members[np.concatenate(lists).astype(np.int64)]
        return borders, found
