"""Synthetic footprint: what a wider beam would have measured (Kaasalainen 2018, section 4).

The mean over all points whose beams lie within a circle of diameter s around a point's own beam,
s measured across the beam at the point: points of other leaves count as well, however far before
or behind. That is what a wide beam sees, and why a ball around the point would be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.chunks import run_in_pieces, split_evenly
from app.core.errors import WrongUse
from app.core.neighbours.range_image import TILE, build_image
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid, as_cells
from app.core.progress import QUIET, Progress

LARGEST = 100.0
PIECE = 10_000
TREE_PIECE = 1_000


@dataclass(frozen=True, slots=True, eq=False)
class Smoothed:
    """Means over synthetic footprints.

    Attributes
    ----------
    values : (channels, k) array
        NaN where no point is in the footprint.
    count : (k,) integers
        Points that were averaged.
    """

    values: Floats
    count: Ints


def smooth(
    values: Floats,
    xyz: Floats,
    scanner: AnyArray,
    grid: ScanGrid | None,
    diameter: float,
    points: Ints | None = None,
    left_out: Bools | None = None,
    progress: Progress = QUIET,
    lines: Lines | None = None,
) -> Smoothed:
    """Average channels over a footprint around each point.

    Where there is a grid, its cells are summed row by row: a footprint costs as many steps as it
    has rows. Beams of a cell count as one; elsewhere each beam is looked up in a tree.

    Parameters
    ----------
    values : (channels, n) array
        Points without a finite value in every channel are left out.
    xyz : (n, 3) metres
    scanner : (3,) metres
    grid : ScanGrid or None
    diameter : float
        Metres, across the beam at the point.
    points : (k,) or None
        Numbers of the points asked for; None means all.
    left_out : (n,) bools, optional
        Points that do not count.
    progress : Progress
    lines : Lines or None
        What `find_lines` found of this grid; None looks again.

    Raises
    ------
    WrongUse
        The diameter is not a positive length.
    Cancelled
    """
    check_diameter(diameter)
    scanner = np.array(scanner, dtype=np.float64)
    away = np.linalg.norm(xyz - scanner, axis=1)
    counted = np.isfinite(values).all(axis=0) & finite_rows(xyz) & (away > 0.0)
    if left_out is not None:
        counted &= ~left_out
    asked = np.arange(len(xyz)) if points is None else np.asarray(points, np.int64)
    half = np.arctan(diameter / (2.0 * np.where(away > 0.0, away, np.nan)[asked]))
    lines = lines or find_lines(xyz, scanner, grid)
    if lines is not None and grid is not None:
        return _smooth_grid(values, lines, as_cells(grid), counted, asked, half, progress)
    return smooth_by_tree(values, (xyz - scanner) / away[:, None], counted, asked, half, progress)


def check_diameter(diameter: float) -> None:
    """Refuse (`WrongUse`) what is no diameter of a footprint."""
    if not 0.0 < diameter <= LARGEST:
        raise WrongUse(
            f"A synthetic footprint has a diameter above 0 and up to {LARGEST:g} m, "
            f"not {diameter:g} m."
        )


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Directions of the rows and columns of a grid.

    Attributes
    ----------
    elevation : (rows,) radians
    azimuth : (columns,) radians
        Unwrapped.
    step : (columns,) radians
        From each column to the next, signed.
    seam : bool
        The last column lies beside the first.
    """

    elevation: Floats
    azimuth: Floats
    step: Floats
    seam: bool


def find_lines(xyz: Floats, scanner: AnyArray, grid: ScanGrid | None) -> Lines | None:
    """Directions of a grid; None where there is no grid, or it does not follow the beams."""
    if grid is None:
        return None
    try:
        return learn_lines(xyz, np.array(scanner, dtype=np.float64), as_cells(grid))
    except UnusableGrid:
        return None


def learn_lines(xyz: Floats, scanner: Floats, cells: Cells) -> Lines:
    """Learn where rows and columns point, about the scanner's own axes.

    Raises
    ------
    BadInput
        The grid belongs to other points.
    UnusableGrid
        Its cells do not follow the beams.
    """
    tiles = (-(-cells.rows // TILE), -(-cells.columns // TILE))
    beams = build_image(xyz, scanner, cells, np.ones(tiles, bool)).beams
    offset = (xyz - scanner) @ beams.axes.T
    usable = np.isfinite(offset).all(axis=1) & (offset != 0.0).any(axis=1)
    offset, row, column = offset[usable], cells.row[usable], cells.column[usable]
    height = np.arctan2(offset[:, 2], np.hypot(offset[:, 0], offset[:, 1]))
    count = np.bincount(row, minlength=cells.rows)
    elevation = np.bincount(row, height, cells.rows) / np.maximum(count, 1)
    turn = np.arctan2(offset[:, 1], offset[:, 0])
    parts = [np.bincount(column, part(turn), cells.columns) for part in (np.sin, np.cos)]
    known = np.bincount(column, minlength=cells.columns) > 0
    azimuth = np.full(cells.columns, np.nan)
    azimuth[known] = np.unwrap(np.arctan2(*parts)[known])
    return Lines(_fill(elevation, count > 0), _fill(azimuth, known), beams.turn, beams.seam)


def _fill(angles: Floats, known: Bools) -> Floats:
    lines, places = np.arange(len(angles)), np.flatnonzero(known)
    return np.asarray(np.interp(lines, places, angles[places]), np.float64)


def _smooth_grid(
    values: Floats, lines: Lines, cells: Cells, counted: Bools, asked: Ints, half: Floats,
    progress: Progress,
) -> Smoothed:  # fmt: skip
    from app.core.kernels.synthetic_footprint import sum_discs

    shape = (cells.rows, cells.columns)
    place = cells.row[counted].astype(np.int64) * cells.columns + cells.column[counted]
    # Count and channels of a cell lie side by side: they are fetched together.
    sums = np.zeros((cells.rows, cells.columns + 1, len(values) + 1))
    for number, channel in enumerate((None, *values)):
        weights = None if channel is None else channel[counted]
        cell = np.bincount(place, weights, cells.rows * cells.columns).reshape(shape)
        np.cumsum(cell, axis=1, out=sums[:, 1:, number])
    found = np.empty((len(asked), len(values) + 1))
    row, column = cells.row[asked], cells.column[asked]
    level = np.cos(lines.elevation)

    def work(first: int, last: int) -> None:
        sum_discs(
            sums, lines.elevation, level, lines.azimuth, lines.step, lines.seam,
            row[first:last], column[first:last], half[first:last], found[first:last],
        )  # fmt: skip

    run_in_pieces(work, split_evenly(len(asked), PIECE), progress, "synthetic footprint")
    return _divide(found.T[1:], found[:, 0])


def smooth_by_tree(
    values: Floats, beams: Floats, counted: Bools, asked: Ints, half: Floats,
    progress: Progress = QUIET,
) -> Smoothed:  # fmt: skip
    """The same by looking up neighbouring beams in a tree of directions.

    Parameters
    ----------
    values : (channels, n) array
    beams : (n, 3)
        Unit vectors.
    counted : (n,) bools
    asked : (k,) numbers
    half : (k,) radians
        Half angle of each footprint as seen from the scanner.
    """
    from scipy.spatial import cKDTree

    rows, fine = np.flatnonzero(counted), np.flatnonzero(np.isfinite(half))
    found = np.zeros((len(values) + 1, len(asked)))
    if not len(rows):
        return _divide(found[1:], found[0])
    tree = cKDTree(beams[rows])
    for begin in range(0, len(fine), TREE_PIECE):
        progress.report(begin / len(fine), "synthetic footprint")
        part = fine[begin : begin + TREE_PIECE]
        near = tree.query_ball_point(beams[asked[part]], 2.0 * np.sin(half[part] / 2.0))
        member = rows[np.concatenate([np.asarray(each, np.int64) for each in near])]
        whose = np.repeat(np.arange(len(part)), [len(each) for each in near])
        found[0, part] = np.bincount(whose, minlength=len(part))
        for number, channel in enumerate(values, 1):
            found[number, part] = np.bincount(whose, channel[member], len(part))
    return _divide(found[1:], found[0])


def _divide(sums: Floats, count: Floats) -> Smoothed:
    with np.errstate(invalid="ignore", divide="ignore"):
        return Smoothed(np.where(count > 0, sums / count, np.nan), count.astype(np.int64))
