"""Neighbours from the scan grid: points sorted by cell, windows sized by angle and range."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.neighbours.steps import Cells, ScanGrid, Steps, as_cells, measure_steps

TILE = 32
MOST_CELLS = 1024


@dataclass(frozen=True, slots=True, eq=False)
class SortedGrid:
    """Usable points of a scan, cell by cell, row by row.

    Attributes
    ----------
    x, y, z : (m,) metres
    member : (m,) int64
        Number of each point in the scan.
    start : (rows · columns + 1,) integers
        The points of cell k are start[k] to start[k + 1].
    grid : Cells
    steps : Steps
    """

    x: Floats
    y: Floats
    z: Floats
    member: Ints
    start: AnyArray
    grid: Cells
    steps: Steps


def sort_grid(
    xyz: Floats,
    scanner: Floats,
    grid: ScanGrid,
    points: Ints | None,
    widths: Floats,
    least: int = 0,
) -> SortedGrid:
    """Sort the points that the windows of the asked points can touch; the rest stays out.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    grid : ScanGrid
    points : (k,) or None
        Numbers of the asked points; None means all.
    widths : (w,) metres
        Half-widths that the windows may take.
    least : int
        Cells on either side of an asked point that are needed in any case.

    Raises
    ------
    BadInput, UnusableGrid
        See `measure_steps`.
    """
    from app.core.kernels.grid import mark_tiles, sort_by_cell

    grid = as_cells(grid)
    steps = measure_steps(xyz, scanner, grid)
    shape = (-(-grid.rows // TILE), -(-grid.columns // TILE))
    marks = np.full(shape, points is None)
    if points is not None:
        mark_tiles(
            xyz, grid.row, grid.column, points, scanner, steps.down, steps.across, steps.seam,
            widths, MOST_CELLS, least, TILE, marks,
        )  # fmt: skip
    small = len(xyz) < 2**31
    start = np.zeros(grid.rows * grid.columns + 2, np.int32 if small else np.int64)
    x, y, z, member = sort_by_cell(
        xyz, grid.row, grid.column, scanner, marks, TILE, grid.columns, start
    )
    return SortedGrid(x, y, z, member, start[:-1], grid, steps)
