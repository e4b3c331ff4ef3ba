"""Means of a leaf's intensity over the beam's own footprint, and the noise they rest on.

Beams lie closer than they are wide, so that neighbours see the same surface: their mean has less
noise, and no less detail. Only points of the same leaf that the beam hits wholly, and no ghosts,
are averaged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import WrongUse
from app.core.neighbours.steps import Cells, ScanGrid, as_cells
from app.core.synthetic_footprint import Lines, smooth
from app.core.wrinkling.offset import Scale

TO_SIGMA = 1.0 / 0.6744897501960817
LEAST_PAIRS, LEAST_STENCILS = 10, 30
STENCIL = 6.0
"""Root of the sum of squares of 1 −2 1 times 1 −2 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """Means of the points of a leaf.

    Attributes
    ----------
    values : (k,)
        NaN where no full hit lies within the footprint.
    count : (k,)
        Full hits that were averaged.
    """

    values: Floats
    count: Ints


def average_leaf(
    values: Floats,
    xyz: Floats,
    scanner: AnyArray,
    diameter: float,
    full: Bools | None = None,
    cells: Cells | None = None,
    lines: Lines | None = None,
) -> Means:
    """Mean over the footprint around each point of one leaf.

    Parameters
    ----------
    values : (k,) array
    xyz : (k, 3) metres
        Points of that leaf, and no others.
    scanner : (3,) metres
    diameter : float
        Of the footprint across the beam, metres.
    full : (k,) bools or None
        Points that the beam hits wholly; only they are averaged.
    cells, lines
        Rows and columns of these points and their directions, as `cut_grid` gives them.
    """
    left_out = None if full is None else ~np.asarray(full, bool)
    found = smooth(
        np.asarray(values, np.float64)[None], xyz, scanner, cells, diameter, None, left_out,
        lines=lines,
    )  # fmt: skip
    return Means(found.values[0], found.count)


def cut_grid(grid: ScanGrid, lines: Lines, points: Ints) -> tuple[Cells, Lines]:
    """The part of a grid that holds some points, so that a leaf costs no more than a leaf."""
    cells = as_cells(grid)
    row, column = cells.row[points], cells.column[points]
    top, bottom = int(row.min()), int(row.max()) + 1
    left, right = int(column.min()), int(column.max()) + 1
    if lines.seam and right - left > cells.columns // 2:
        left, right = 0, cells.columns  # the leaf may lie across the seam
    whole = right - left == cells.columns
    part = Cells(bottom - top, right - left, row - np.int32(top), column - np.int32(left))
    return part, Lines(
        lines.elevation[top:bottom],
        lines.azimuth[left:right],
        lines.step[left:right],
        lines.seam and whole,
    )


def measure_noise(
    values: Floats,
    xyz: Floats,
    scanner: AnyArray,
    scale: Scale,
    full: Bools | None = None,
    cells: Cells | None = None,
) -> float:
    """Noise of one intensity, from how neighbours along the beams differ.

    With rows and columns, the stencil 1 −2 1, once down and once across (Immerkær 1996, Computer
    Vision and Image Understanding 64): slopes and bends of the intensity cancel. Without them, a
    point less the mean of its four neighbours: slopes cancel. The median of the absolute value
    is taken. A scanner that averages neighbours before it writes them hides its noise from both.

    Returns
    -------
    float
        A share of the intensity on a linear scale, DN on a logarithmic one; NaN where too few
        points lie together.
    """
    known = np.isfinite(values) & np.isfinite(xyz).all(axis=1)
    if full is not None:
        known &= full
    if scale == "linear":
        known &= values > 0.0
    level = np.full(len(values), np.nan)
    level[known] = np.log(values[known]) if scale == "linear" else values[known]
    if cells is not None:
        apart = _fold(level, cells)
        if len(apart) >= LEAST_STENCILS:
            return float(np.median(np.abs(apart)) * TO_SIGMA / STENCIL)
    rows = np.flatnonzero(known)
    if len(rows) < LEAST_PAIRS:
        return float("nan")
    from scipy.spatial import cKDTree

    away = xyz[rows] - scanner
    beams = away / np.linalg.norm(away, axis=1, keepdims=True)
    near = np.asarray(cKDTree(beams).query(beams, k=5)[1])
    apart = level[rows] - level[rows][near[:, 1:]].mean(axis=1)
    return float(np.median(np.abs(apart)) * TO_SIGMA / np.sqrt(1.25))


def _fold(level: Floats, cells: Cells) -> Floats:
    """1 −2 1 down and across at every cell whose nine values are known."""
    image = np.full((cells.rows + 2, cells.columns + 2), np.nan)
    image[cells.row + 1, cells.column + 1] = level
    down = image[:-2] - 2.0 * image[1:-1] + image[2:]
    both = down[:, :-2] - 2.0 * down[:, 1:-1] + down[:, 2:]
    return np.asarray(both[np.isfinite(both)], np.float64)


def noise_of_means(noise: float, values: Floats, count: Ints, scale: Scale) -> Floats:
    """Noise of each mean, in the unit of the intensity.

    Parameters
    ----------
    noise : float
        As `measure_noise` gives it.
    """
    if not noise >= 0.0:
        raise WrongUse(f"The noise of an intensity is a number from 0 on, not {noise:g}.")
    level = np.abs(values) * noise if scale == "linear" else np.full(len(values), noise)
    return np.asarray(level / np.sqrt(np.maximum(count, 1)), np.float64)
