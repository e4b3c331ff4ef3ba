"""Planes on the range image, in windows that follow the rules of an estimator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces
from app.core.neighbours.range_image import TILE, RangeImage, build_image
from app.core.neighbours.steps import Cells
from app.core.normals.rules import HALO, Rules
from app.core.progress import QUIET, Progress

MakeRules = Callable[[float, float], Rules]


@dataclass(frozen=True, slots=True, eq=False)
class ImagePlanes:
    """A plane for each point asked for.

    Attributes
    ----------
    normals : (k, 3)
        Unit vectors towards the scanner; NaN where no plane is defined.
    count : (k,) int32
        Cells in the window (robust fits: sum of their weights, rounded).
    width : (k,) float32, metres
        Half-width of the window, the larger of the two; 0 without a plane.
    rms : (k,) float32, metres
        Root mean square distance from the plane.
    sigma : (k,) float32, radians
        Standard error of the angle of incidence.
    left : (l,) integers
        Places, among those asked for, of points that no window was laid around: they share
        their cell with a nearer one, rows and columns are uneven there, or have no range.
    seconds : dict
        'neighbours' (the range image) and 'planes' (windows and fits).
    """

    normals: Floats
    count: AnyArray
    width: AnyArray
    rms: AnyArray
    sigma: AnyArray
    left: Ints
    seconds: dict[str, float]


def fit_image(
    xyz: Floats, scanner: Floats, cells: Cells, asked: Ints | None, radius: float,
    make_rules: MakeRules, progress: Progress = QUIET,
) -> ImagePlanes:  # fmt: skip
    """Fit a plane at each point asked for.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    cells : Cells
    asked : (k,) or None
        Numbers of points, rising, each once; None means all. Work is proportional to them,
        but for one look at the cell of every point.
    radius : float
        Metres.
    make_rules : callable
        Of an estimator: from radius and noise of the range.

    Raises
    ------
    BadInput, UnusableGrid
        See `build_image`.
    Cancelled
    """
    begun = perf_counter()
    wanted, marks = mark_tiles(cells, asked)
    image = build_image(xyz, scanner, cells, marks)
    middle = perf_counter()
    size = len(xyz) if asked is None else len(asked)
    normals, count, width, rms, sigma = found = _make_room(
        size, asked is None and image.filled == size
    )
    slot = _place_results(cells, image, asked)
    _fit(xyz, scanner, image, slot, wanted, make_rules(radius, image.noise), found, progress)
    left = np.flatnonzero(count < 0)
    count[left] = 0
    seconds = {"neighbours": middle - begun, "planes": perf_counter() - middle}
    return ImagePlanes(normals, count, width, rms, sigma, left, seconds)


def mark_tiles(cells: Cells, asked: Ints | None) -> tuple[Ints, Bools]:
    """Tiles with asked points, (t, 4), and all that their windows touch, as marks.

    A tile is: first row and column, row and column after the last. It is always done from the
    same corner, so that the same sums are rounded the same way whatever is asked for.
    """
    shape = (-(-cells.rows // TILE), -(-cells.columns // TILE))
    wanted, marks = np.ones(shape, bool), np.ones(shape, bool)
    if asked is not None:
        place = np.column_stack([cells.row[asked], cells.column[asked]]).astype(np.int64)
        place = place[((place >= 0) & (place < (cells.rows, cells.columns))).all(axis=1)]
        wanted[:] = False
        wanted[place[:, 0] // TILE, place[:, 1] // TILE] = True
        marks = _add_halo(wanted, cells)
    first = np.argwhere(wanted) * TILE
    last = np.minimum(first + TILE, (cells.rows, cells.columns))
    return np.ascontiguousarray(np.hstack([first, last]), np.int64), marks


def _add_halo(wanted: Bools, cells: Cells) -> Bools:
    """The wanted tiles, those around them, and those beyond the seam."""
    marks = wanted.copy()
    marks[1:] |= wanted[:-1]
    marks[:-1] |= wanted[1:]
    tall = marks.copy()
    marks[:, 1:] |= tall[:, :-1]
    marks[:, :-1] |= tall[:, 1:]
    ends = tall[:, [0, -1]]
    marks[:, -1] |= ends[:, 0]
    marks[:, 0] |= ends[:, 1]
    if cells.columns % TILE < HALO and marks.shape[1] > 1:  # the last tile is narrow
        marks[:, -2] |= ends[:, 0]
        marks[:, 0] |= tall[:, -2]
    return marks


def _make_room(size: int, touched: bool) -> tuple[AnyArray, ...]:
    """Results; the kernels fill them, in their threads, unless some points have no cell."""
    normals = np.empty((size, 3))
    count, width = np.empty(size, np.int32), np.empty(size, np.float32)
    rms, sigma = np.empty(size, np.float32), np.empty(size, np.float32)
    if not touched:
        normals.fill(np.nan)
        rms.fill(np.nan)
        sigma.fill(np.nan)
        width.fill(0.0)
        count.fill(-1)
    return normals, count, width, rms, sigma


def _place_results(cells: Cells, image: RangeImage, asked: Ints | None) -> AnyArray:
    """Where the result of each cell goes, from 1, 0 for nowhere; empty: all, by point."""
    kind = image.number.dtype
    if asked is None:
        return np.empty((0, 0), kind)
    row, column = cells.row[asked], cells.column[asked]
    own = np.flatnonzero(image.number[row, column] == asked + 1)
    slot = np.zeros(image.number.shape, kind)
    slot[row[own], column[own]] = own + 1
    return slot


def _fit(
    xyz: Floats, scanner: Floats, image: RangeImage, slot: AnyArray, tiles: Ints,
    rules: Rules, found: tuple[AnyArray, ...], progress: Progress,
) -> None:  # fmt: skip
    from app.core.kernels import image_planes as kernel
    from app.core.kernels.tiles import Image

    beams = image.beams
    table = Image(
        image.inverse, image.number, beams.down, beams.turn, beams.level, beams.uneven_row,
        beams.uneven_column, beams.axes, beams.seam, xyz, scanner,
    )  # fmt: skip
    places = kernel.Found(*found)

    def work(first: int, last: int) -> None:
        kernel.fit_tiles(table, slot, tiles[first:last], TILE, rules, places)

    run_in_pieces(work, np.arange(len(tiles) + 1), progress, "local planes")
