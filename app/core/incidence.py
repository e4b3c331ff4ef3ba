"""Local planes and the angle at which the beam meets them (Junttila 2016, 2.6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from time import perf_counter

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, read_only
from app.core.chunks import run_in_pieces, split_evenly
from app.core.errors import WrongUse
from app.core.neighbours.asked import as_points, each_once, slots_of
from app.core.neighbours.grid import MOST_CELLS, SortedGrid, sort_grid
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid
from app.core.neighbours.voxel import SortedVoxels, crop_to, sort_voxels
from app.core.progress import QUIET, Progress

RADIUS = 0.004
ENOUGH = 6
FACTORS = np.append(1.5 ** np.arange(6), 10.0)
"""Sizes that the ball may take, in radii."""
LEVELS = (slice(0, 1), slice(1, 3), slice(3, 5), slice(5, 7))
"""Factors that share one voxel size, in the search without a grid."""


@dataclass(frozen=True, slots=True, eq=False)
class LocalPlanes:
    """A plane at each asked point.

    Attributes
    ----------
    normals : (k, 3)
        Unit vectors towards the scanner's side; NaN where no plane is defined.
    count : (k,) int64
        Points in the ball, the point itself included.
    width : (k,) metres
        Radius of the ball that was used; 0 where the point has no range.
    rms : (k,) metres
        Root mean square distance of the ball's points from the plane.
    method : {'scan grid', 'voxel hash'}
    reason : str
        Why this method was taken.
    seconds : dict
        'neighbours' (sorting) and 'planes' (windows and fits), without compilation.
    """

    normals: Floats
    count: Ints
    width: Floats
    rms: Floats
    method: str
    reason: str
    seconds: dict[str, float]


def incidence_angle(xyz: Floats, normals: Floats, scanner: AnyArray) -> Floats:
    """Angle between the beam and the normal.

    Parameters
    ----------
    xyz, normals : (k, 3)
        Points in metres, and a normal at each (of any sign).
    scanner : (3,) metres

    Returns
    -------
    (k,) radians, 0 to π/2
        atan2(|P × N|, |P · N|): arccos would lose half its digits near 0. NaN where the
        normal is NaN or the point lies at the scanner.
    """
    beams = xyz - np.asarray(scanner, dtype=np.float64)
    across = np.linalg.norm(np.cross(beams, normals), axis=1)
    angle: Floats = np.arctan2(across, np.abs((beams * normals).sum(axis=1)))
    angle[~beams.any(axis=1)] = np.nan
    return angle


def local_planes(
    xyz: Floats,
    scanner: AnyArray,
    points: Ints | None = None,
    radius: float = RADIUS,
    grid: ScanGrid | None = None,
    progress: Progress = QUIET,
) -> LocalPlanes:
    """Fit a plane by total least squares to the points in a ball around each asked point.

    A ball with fewer than six points, or with all on one line as the scanner sees them, grows
    in steps of 1.5 up to ten times the radius; on a grid it stops growing once its window has
    1024 cells. A point that still has fewer than three, or a line, gets NaN, as does one
    without finite coordinates or range.

    Parameters
    ----------
    xyz : (n, 3) metres, world
    scanner : (3,) metres
    points : (k,) or None
        Numbers of the points asked for; None means all. Work is proportional to them.
    radius : float
        Metres.
    grid : ScanGrid or None
    progress : Progress

    Raises
    ------
    BadInput
        The grid belongs to other points.
    WrongUse
        The radius is not positive, or a point number does not exist.
    Cancelled
    """
    if not (0.0 < radius < np.inf):
        raise WrongUse(f"The radius must be positive, not {radius} m.")
    warm_up()
    return _local_planes(
        as_points(xyz),
        np.array(scanner, dtype=np.float64),
        points, radius, grid, progress,
    )  # fmt: skip


def _local_planes(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float,
    grid: ScanGrid | None, progress: Progress,
) -> LocalPlanes:  # fmt: skip
    asked, where = each_once(points, len(xyz))
    fit = _Fit(xyz, scanner, asked, radius * FACTORS)
    reason = "the scan has no rows and columns"
    method = "voxel hash"
    if grid is not None:
        try:
            fit.run_on_grid(grid, progress)
            method, reason = "scan grid", "rows and columns are known"
        except UnusableGrid as refusal:
            reason = str(refusal)
    if method == "voxel hash":
        fit.run_in_voxels(progress)
    return fit.result(where, method, reason)


class _Fit:
    """Arrays that the kernels fill, and the two ways to fill them."""

    def __init__(self, xyz: Floats, scanner: Floats, asked: Ints | None, widths: Floats) -> None:
        self.xyz, self.scanner, self.asked, self.widths = xyz, scanner, asked, widths
        size = len(xyz) if asked is None else len(asked)
        self.normals = np.full((size, 3), np.nan)
        self.count = np.zeros(size, np.int64)
        self.width = np.zeros(size)
        self.rms = np.full(size, np.nan)
        self.seconds = {"neighbours": 0.0, "planes": 0.0}

    def run_on_grid(self, grid: ScanGrid, progress: Progress) -> None:
        begun = perf_counter()
        index = sort_grid(self.xyz, self.scanner, grid, self.asked, self.widths)
        slot = slots_of(self.asked, len(self.xyz))
        self.seconds["neighbours"] += perf_counter() - begun
        begun = perf_counter()
        self._fit_in_windows(index, slot, progress)
        self.seconds["planes"] += perf_counter() - begun

    def _fit_in_windows(self, index: SortedGrid, slot: AnyArray, progress: Progress) -> None:
        from app.core.kernels.grid import fit_in_windows

        steps, grid = index.steps, index.grid

        def work(first: int, last: int) -> None:
            fit_in_windows(
                index.x, index.y, index.z, index.member, index.start, grid.row, grid.column,
                slot, first, last, self.scanner, steps.down, steps.across, steps.seam,
                self.widths, ENOUGH, MOST_CELLS,
                self.normals, self.count, self.width, self.rms,
            )  # fmt: skip

        run_in_pieces(work, split_evenly(len(index.member)), progress, "local planes")

    def run_in_voxels(self, progress: Progress) -> None:
        """Level by level: the voxels grow, and only points without a plane stay."""
        begun = perf_counter()
        slot = slots_of(self.asked, len(self.xyz))
        left = self._usable()
        numbers = left
        self.seconds["neighbours"] += perf_counter() - begun
        for level, factors in enumerate(LEVELS):
            if not len(left):
                break
            widths = self.widths[factors]
            part = progress.part(level / len(LEVELS), (level + 1) / len(LEVELS))
            part.report(0.0, "neighbours")
            begun = perf_counter()
            cropped = self.asked is not None or level > 0
            reach = float(widths[-1])
            kept = crop_to(self.xyz, self.scanner, left, reach) if cropped else left
            index = sort_voxels(self.xyz, kept, reach)
            self.seconds["neighbours"] += perf_counter() - begun
            begun = perf_counter()
            self._fit_in_voxels(index, slot, widths, level == len(LEVELS) - 1, part)
            left = numbers[self.width[slot[numbers]] == 0.0]
            self.seconds["planes"] += perf_counter() - begun
        progress.report(1.0)

    def _fit_in_voxels(
        self, index: SortedVoxels, slot: AnyArray, widths: Floats, final: bool, progress: Progress
    ) -> None:
        from app.core.kernels.voxels import fit_in_voxels

        def work(first: int, last: int) -> None:
            fit_in_voxels(
                index.x, index.y, index.z, index.member, index.keys, index.start, slot,
                first, last, self.scanner, widths, ENOUGH, final,
                self.normals, self.count, self.width, self.rms,
            )  # fmt: skip

        places = split_evenly(len(index.member))
        borders = np.searchsorted(index.start, places)
        run_in_pieces(work, borders, progress, "local planes")

    def _usable(self) -> Ints:
        """Asked points with a finite range above zero."""
        asked = self.xyz if self.asked is None else self.xyz[self.asked]
        with np.errstate(invalid="ignore", over="ignore"):
            square = ((asked - self.scanner) ** 2).sum(axis=1)
        usable: Bools = np.isfinite(square) & (square > 0.0)
        places = np.flatnonzero(usable)
        return places if self.asked is None else self.asked[places]

    def result(self, where: Ints | slice, method: str, reason: str) -> LocalPlanes:
        return LocalPlanes(
            self.normals[where], self.count[where], self.width[where], self.rms[where],
            method, reason, self.seconds,
        )  # fmt: skip


@cache
def warm_up() -> None:
    """Compile, or load, the kernels once, so that no measured second holds it."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:4, :4])
    xyz = np.stack([np.ones(16), column / 1000.0, row / 1000.0], axis=1)
    grid = Cells(4, 4, row, column)
    asked = np.arange(3)
    _local_planes(read_only(xyz), np.zeros(3), asked, RADIUS, grid, QUIET)
    _local_planes(read_only(xyz), np.zeros(3), asked, RADIUS, None, QUIET)
