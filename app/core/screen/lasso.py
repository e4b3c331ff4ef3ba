"""A freehand polygon as a picture of pixels, and the points under it."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.screen.projection import Pixels, for_kernel


def rasterise_polygon(polygon: Floats, size: tuple[int, int]) -> Bools:
    """Pixels whose centre is inside a closed polygon.

    The **nonzero winding** rule: a loop drawn twice around, or a hand that crosses its own
    line, keeps its inside, where even-odd would punch holes into it.

    Parameters
    ----------
    polygon : (k, 2) array
        Corners in pixels, y down, closed by itself; corners outside the screen are fine.
    size : (width, height)

    Returns
    -------
    (height, width) bool array

    Raises
    ------
    BadInput
        Fewer than three corners, or one that is not finite.
    """
    corners = np.asarray(polygon, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise BadInput("A lasso needs at least three corners.")
    if not np.isfinite(corners).all():
        raise BadInput("A corner of the lasso is not a number.")
    width, height = size
    row, column, sign = _crossings(corners, width, height)
    steps = np.zeros((height, width + 1), np.int32)
    np.add.at(steps, (row, column), sign)
    winding = np.cumsum(steps[:, :width], axis=1, dtype=np.int32)
    return np.not_equal(winding, 0)


def _crossings(corners: Floats, width: int, height: int) -> tuple[Ints, Ints, Ints]:
    """Row, first pixel to the right, and direction of every edge on every row of centres."""
    start, stop = corners, np.roll(corners, -1, axis=0)
    sign = np.where(start[:, 1] < stop[:, 1], 1, -1)
    upper, lower = np.minimum(start[:, 1], stop[:, 1]), np.maximum(start[:, 1], stop[:, 1])
    # Half-open, [upper, lower): a corner on a row of centres counts for one of its edges.
    first = np.clip(np.ceil(upper - 0.5), 0, height).astype(np.int64)
    end = np.clip(np.ceil(lower - 0.5), 0, height).astype(np.int64)
    rows_of = end - first
    edge = np.repeat(np.arange(len(corners)), rows_of)
    row = np.arange(len(edge)) - np.repeat(np.cumsum(rows_of) - rows_of, rows_of) + first[edge]
    begin, along = start[edge], (stop - start)[edge]
    x = begin[:, 0] + (row + 0.5 - begin[:, 1]) / along[:, 1] * along[:, 0]
    column = np.clip(np.ceil(x - 0.5), 0, width).astype(np.int64)
    return row, column, sign[edge]


def lasso_mask(px: Pixels, polygon: Floats, size: tuple[int, int]) -> Bools:
    """Points whose pixel is inside a polygon.

    Parameters
    ----------
    px : (n, 2) float32 array
        Pixels, y down; NaN and points off the screen are never inside.
    polygon : (k, 2) array
        Corners in pixels (see `rasterise_polygon`).
    size : (width, height)

    Returns
    -------
    (n,) bool array
    """
    from app.core.kernels import screen

    found = np.empty(len(px), np.bool_)
    picture = rasterise_polygon(polygon, size)
    screen.look_up(for_kernel(px, np.float32), for_kernel(picture, np.bool_), found)
    return found
