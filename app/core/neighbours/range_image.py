"""The scan as a range image: 1 / range in each cell, and how far apart its beams are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.chunks import count_processors, run_in_pieces, split_evenly
from app.core.errors import BadInput
from app.core.neighbours.beams import Beams, learn_beams
from app.core.neighbours.steps import Cells, check_shape, noise_of_bends

TILE = 128
APART = 3
LINES = 24
"""Pairs of rows that noise and beams are tested on; the same whatever points are asked for."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeImage:
    """One over the range in each cell of a scan grid.

    Attributes
    ----------
    inverse : (rows, columns) 1 / metres
        Where `number` is 0 it means nothing.
    number : (rows, columns) int32 or int64
        Number of the point, from 1; 0 without one.
    beams : Beams
    noise : float
        Metres: standard deviation of the range, from how it jumps about the line through its
        two neighbours; surfaces with structure make it larger.
    filled : int
        Cells with a point; fewer than points where some share a cell, or have no range.
    """

    inverse: Floats
    number: AnyArray
    beams: Beams
    noise: float
    filled: int


def build_image(xyz: Floats, scanner: Floats, cells: Cells, marks: AnyArray) -> RangeImage:
    """Lay the points of marked tiles out as the scanner saw them.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    cells : Cells
    marks : (rows / TILE, columns / TILE) bool, rounded up
        Tiles to fill; the others stay empty.

    Raises
    ------
    BadInput
        The grid belongs to other points.
    UnusableGrid
        It is nearly empty, or its cells do not follow the beams from this position.
    """
    from app.core.kernels.range_image import fill_image

    check_shape(xyz, cells)
    shape = (cells.rows, cells.columns)
    inverse = np.zeros(shape)
    number = np.zeros(shape, np.int32 if len(xyz) < 2**31 - 1 else np.int64)
    lines = np.unique(np.linspace(0, max(cells.rows - 2, 0), LINES).astype(np.int64))
    always = np.zeros(cells.rows + 1, bool)
    always[lines] = always[lines + 1] = True
    counts: list[tuple[int, int]] = []

    def work(first: int, last: int) -> None:
        counts.append(
            fill_image(
                xyz, cells.row, cells.column, scanner, marks, TILE, always, first, last,
                inverse, number,
            )
        )  # fmt: skip

    run_in_pieces(work, split_evenly(cells.rows, -(-cells.rows // count_processors())))
    if any(outside for _, outside in counts):
        raise BadInput(
            f"A point lies outside the grid of {cells.rows} × {cells.columns} cells.",
            "The file's rows or columns are damaged.",
        )
    beams = learn_beams(xyz, scanner, cells, number, lines)
    noise = measure_noise(inverse[lines])
    return RangeImage(inverse, number, beams, noise, sum(filled for filled, _ in counts))


def measure_noise(inverse: Floats) -> float:
    """Standard deviation of the range, metres, from second differences along rows (robust).

    Of cells three apart: scanners that average 3 × 3 cells show less noise between neighbours.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = 1.0 / inverse
        bend = (
            distance[:, : -2 * APART] - 2.0 * distance[:, APART:-APART] + distance[:, 2 * APART :]
        )
        bend = np.abs(bend)
    return noise_of_bends(bend)
