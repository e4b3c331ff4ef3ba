"""A leaf as a picture of cells: a value, grey for what is not valid, or nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.render.palettes import Rgb, colour_table
from app.services.wrinkles.picture import frame_leaf

PALETTE = "delta-omega"
LEAST_CELLS, MOST_CELLS = 8, 400
NEIGHBOURS_TO_FILL = 4


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Cells of a square about a leaf.

    Attributes
    ----------
    values : (n, n)
        Mean of the valid points; NaN without one.
    grey : (n, n) bools
        Cells whose points are all not valid.
    left, low, side : float
        Place and size of the square, mm.
    """

    values: Floats
    grey: Bools
    left: float
    low: float
    side: float


def find_spacing(x: Floats, y: Floats) -> float:
    """Side of a cell, mm, that about one point falls into, for a leaf seen from the scanner."""
    wide, high = (max(float(np.ptp(np.quantile(side, (0.02, 0.98)))), 1e-6) for side in (x, y))
    return float(np.sqrt(wide * high / len(x)))


def rasterise(
    x: Floats, y: Floats, values: AnyArray, valid: Bools, framed: Bools, spacing: float
) -> Raster:
    """Average points per cell; points outside the square about the leaf are left out.

    Parameters
    ----------
    x, y : (k,) mm
    values : (k,) array
    valid, framed : (k,) bools
        Points that count; points that the square is made to hold.
    spacing : float
        Side of a cell, mm.
    """
    left, low, side = frame_leaf(x[framed], y[framed])
    n = int(np.clip(side / spacing, LEAST_CELLS, MOST_CELLS))
    row, column = (np.floor((place - start) / side * n) for place, start in ((y, low), (x, left)))
    inside = (row >= 0) & (row < n) & (column >= 0) & (column < n)

    def add(chosen: Bools, weights: AnyArray | None = None) -> Floats:
        cell = (row[chosen] * n + column[chosen]).astype(np.int64)
        kept = None if weights is None else weights[chosen]
        return np.bincount(cell, kept, n * n).reshape(n, n).astype(np.float64)

    count, other = add(inside & valid), add(inside & ~valid)
    with np.errstate(invalid="ignore"):
        mean = add(inside & valid, values) / count
    known, grey = _close_holes(mean, (count == 0) & (other > 0))
    return Raster(known, grey, left, low, side)


def _close_holes(mean: Floats, grey: Bools) -> tuple[Floats, Bools]:
    """Fill empty cells among filled ones: a fine pattern of gaps is no news of a leaf."""
    around = _look_around(mean)
    known = np.isfinite(around)
    number = known.sum(axis=0)
    other = (_look_around(grey.astype(np.float64)) == 1.0).sum(axis=0)
    near = np.where(known, around, 0.0).sum(axis=0) / np.maximum(number, 1)
    empty = np.isnan(mean) & ~grey
    fill = empty & (number >= NEIGHBOURS_TO_FILL)
    veil = empty & ~fill & (number + other >= NEIGHBOURS_TO_FILL)
    return np.where(fill, near, mean), grey | veil


def _look_around(image: Floats) -> Floats:
    rows, columns = image.shape
    padded = np.pad(image, 1, constant_values=np.nan)
    shifts = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.stack([padded[i : i + rows, j : j + columns] for i, j in shifts])


def paint(raster: Raster, limit: float, grey: Rgb) -> AnyArray:
    """Colours of the cells, (n, n, 4); they end at ±`limit`, empty cells are clear."""
    share = np.clip((np.nan_to_num(raster.values) + limit) / (2.0 * limit), 0.0, 1.0)
    rgba = colour_table(PALETTE)[np.round(share * 255).astype(np.int64)].copy()
    rgba[raster.grey] = (*grey, 255)
    rgba[np.isnan(raster.values) & ~raster.grey, 3] = 0
    return rgba
