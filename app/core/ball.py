"""Total least squares planes in balls: what most programs fit, as the reference.

A ball of fixed radius around each point, and the plane through the mean of its points along
the two directions in which they spread most (Hoppe 1992, section 3.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.chunks import count_processors, run_in_pieces, split_evenly
from app.core.neighbours.asked import slots_of
from app.core.neighbours.grid import MOST_CELLS
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid, as_cells, measure_steps
from app.core.neighbours.voxel import SortedVoxels, crop_to, sort_voxels, usable_points
from app.core.progress import Progress

ENOUGH = 6
FACTORS = np.append(1.5 ** np.arange(6), 10.0)
"""Sizes that the ball may take, in radii."""
LEVELS = (slice(0, 1), slice(1, 3), slice(3, 5), slice(5, 7))
"""Factors that share one voxel size, in the search without a grid."""
PIECE = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class BallPlanes:
    """A plane for each point asked for.

    Attributes
    ----------
    normals : (k, 3)
        Unit vectors towards the scanner's side; NaN where no plane is defined.
    count : (k,) int32
        Points in the ball, the point itself included.
    width : (k,) float32, metres
        Radius of the ball that was used; 0 where the point has no range.
    rms : (k,) float32, metres
        Root mean square distance of the ball's points from the plane.
    method : {'scan grid', 'voxel hash'}
    reason : str
        Why this method was taken.
    seconds : dict
        'neighbours' (sorting) and 'planes' (sums and fits).
    """

    normals: Floats
    count: AnyArray
    width: AnyArray
    rms: AnyArray
    method: str
    reason: str
    seconds: dict[str, float]


def fit_balls(
    xyz: Floats,
    scanner: Floats,
    grid: ScanGrid | None,
    asked: Ints | None,
    radius: float,
    progress: Progress,
) -> BallPlanes:
    """Fit a plane by total least squares to the points in a ball around each asked point.

    A ball with fewer than six points, or with all on one line as the scanner sees them, grows
    in steps of 1.5 up to ten times the radius; on a grid it stops growing once its window has
    1024 cells. A point that still has fewer than three, or a line, gets NaN, as does one
    without finite coordinates or range.

    Parameters
    ----------
    xyz : (n, 3) float64, metres
        As `app.core.neighbours.asked.as_points` gives it.
    scanner : (3,) float64, metres
    grid : ScanGrid or None
    asked : (k,) or None
        Numbers of the points asked for, once each and rising; None means all.
    radius : float
        Metres.
    progress : Progress

    Raises
    ------
    BadInput
        The grid belongs to other points.
    Cancelled
    """
    fit = _Fit(xyz, scanner, asked, radius * FACTORS)
    method, reason = "voxel hash", "the scan has no rows and columns"
    if grid is not None:
        try:
            fit.run_on_grid(grid, progress)
            method, reason = "scan grid", "rows and columns are known"
        except UnusableGrid as refusal:
            reason = str(refusal)
    if method == "voxel hash":
        fit.run_in_voxels(progress)
    return BallPlanes(fit.normals, fit.count, fit.width, fit.rms, method, reason, fit.seconds)


class _Fit:
    """Arrays that the kernels fill, and the two ways to fill them."""

    def __init__(self, xyz: Floats, scanner: Floats, asked: Ints | None, widths: Floats) -> None:
        from app.core.kernels.plane import clear_planes

        self.xyz, self.scanner, self.asked, self.widths = xyz, scanner, asked, widths
        size = len(xyz) if asked is None else len(asked)
        self.normals = np.empty((size, 3))
        self.count = np.empty(size, np.int32)
        self.width = np.empty(size, np.float32)
        self.rms = np.empty(size, np.float32)
        self.seconds = {"neighbours": 0.0, "planes": 0.0}

        def clear(first: int, last: int) -> None:
            clear_planes(first, last, self.normals, self.count, self.width, self.rms)

        run_in_pieces(clear, split_evenly(size, PIECE))

    def run_on_grid(self, grid: ScanGrid, progress: Progress) -> None:
        from app.core.kernels.ball_tiles import TILE, Found, Rules, Scan, fit_in_tiles

        begun = perf_counter()
        cells = as_cells(grid)
        steps = measure_steps(self.xyz, self.scanner, cells)
        head, after = _chain(cells)
        chosen = _choose_tiles(cells, self.asked, TILE)
        slot = slots_of(self.asked, len(self.xyz))
        self.seconds["neighbours"] += perf_counter() - begun
        begun = perf_counter()

        scan = Scan(self.xyz, head, after, slot, self.scanner, steps.down, steps.across, steps.seam)
        rules = Rules(self.widths, ENOUGH, MOST_CELLS)
        found = Found(self.normals, self.count, self.width, self.rms)

        def work(first: int, last: int) -> None:
            fit_in_tiles(scan, rules, chosen, first, last, found)

        run_in_pieces(work, split_evenly(len(chosen), 4), progress, "local planes")
        self.seconds["planes"] += perf_counter() - begun

    def run_in_voxels(self, progress: Progress) -> None:
        """Level by level: the voxels grow, and only points without a plane stay."""
        begun = perf_counter()
        slot = slots_of(self.asked, len(self.xyz))
        left = self._usable()
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
            left = left[self.width[slot[left]] == 0.0]
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
        if self.asked is None:
            return usable_points(self.xyz, self.scanner)
        return self.asked[usable_points(self.xyz[self.asked], self.scanner)]


def _chain(cells: Cells) -> tuple[AnyArray, AnyArray]:
    """First point of each cell, and the next one in the same cell after each point; -1: none."""
    from app.core.kernels.ball_tiles import chain_cells

    kind = np.int32 if len(cells.row) < 2**31 else np.int64
    head = np.empty(cells.rows * cells.columns, kind)
    after = np.empty(len(cells.row), kind)

    def work(first: int, last: int) -> None:
        chain_cells(cells.row, cells.column, first, last, cells.columns, head, after)

    run_in_pieces(work, np.linspace(0, cells.rows, count_processors() + 1).astype(np.int64))
    return head, after


def _choose_tiles(cells: Cells, asked: Ints | None, tile: int) -> Ints:
    """Numbers of the tiles, row by row, that hold points asked for."""
    down, across = -(-cells.rows // tile), -(-cells.columns // tile)
    if asked is None:
        return np.arange(down * across)
    marks = np.zeros((down, across), np.bool_)
    marks[cells.row[asked] // tile, cells.column[asked] // tile] = True
    return np.flatnonzero(marks)
