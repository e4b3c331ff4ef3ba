"""How far apart the beams of a scan grid are, measured from the points themselves.

What a file says about its steps, or its poles, is not needed and not trusted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints, read_only
from app.core.chunks import run_in_pieces
from app.core.errors import BadInput

LINES = 48
PAIRS = 64
MOST_GAP = 4
FAR = 8
LARGEST_SPREAD = 2.5
"""Upper over lower quartile of the angle between neighbouring cells."""
LEAST_STRAIGHT = 0.4
"""Eight cells must look about eight times as far apart as one: 1 on a grid, 1/8 by chance."""
EMPTY_CELLS_PER_POINT = 64
SEAM_COLUMNS = 3


class ScanGrid(Protocol):
    """Rows and columns of a range image; several points may share a cell."""

    @property
    def rows(self) -> int:
        """Number of rows."""

    @property
    def columns(self) -> int:
        """Number of columns."""

    @property
    def row(self) -> AnyArray:
        """Row of each point, (n,) integers from 0."""

    @property
    def column(self) -> AnyArray:
        """Column of each point, (n,) integers from 0."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """A `ScanGrid` whose arrays have the one type that the kernels are compiled for."""

    rows: int
    columns: int
    row: AnyArray
    column: AnyArray


def as_cells(grid: ScanGrid) -> Cells:
    """The same grid with read-only int32 rows and columns; no copy where they are so already."""
    return Cells(int(grid.rows), int(grid.columns), _as_int32(grid.row), _as_int32(grid.column))


def _as_int32(cells: AnyArray) -> AnyArray:
    return read_only(np.ascontiguousarray(cells, dtype=np.int32))


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Angles between the beams of neighbouring cells.

    Attributes
    ----------
    down : (columns,) radians
        From row to row, in each column.
    across : (rows,) radians
        From column to column, in each row; shrinks towards a pole.
    seam : bool
        The last column lies beside the first.
    noise : float
        Metres: standard deviation of the range, from how it jumps about the line through
        its two neighbours; surfaces with structure make it larger.
    """

    down: Floats
    across: Floats
    seam: bool
    noise: float


class UnusableGrid(Exception):
    """The rows and columns cannot be used to find neighbours; the text says why."""


def angle_between(a: Floats, b: Floats) -> Floats:
    """Angle between the vectors of two (n, 3) arrays, (n,) radians, exact near 0 and π."""
    angle: Floats = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
    return angle


def measure_steps(xyz: Floats, scanner: Floats, grid: ScanGrid) -> Steps:
    """Measure the steps of a grid on some of its rows and columns.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    grid : ScanGrid

    Raises
    ------
    BadInput
        The grid does not belong to these points.
    UnusableGrid
        It is nearly empty, or its cells do not follow the beams from this position.
    """
    check_shape(xyz, grid)
    sampled_rows, sampled_columns = _spread(grid.rows), _spread(grid.columns)
    in_rows, in_columns = _sample(grid, sampled_rows, sampled_columns)
    across = _measure_lines(xyz, scanner, in_rows)
    down = _measure_lines(xyz, scanner, in_columns)
    return Steps(
        _fill(down, sampled_columns, grid.columns),
        _fill(across, sampled_rows, grid.rows),
        _finds_seam(xyz, scanner, in_rows, across),
        _measure_noise(xyz, scanner, in_rows),
    )


def check_shape(xyz: Floats, grid: ScanGrid) -> None:
    """Refuse a grid of other points (`BadInput`) or an almost empty one (`UnusableGrid`)."""
    if len(grid.row) != len(xyz) or len(grid.column) != len(xyz):
        raise BadInput(
            f"The grid places {len(grid.row)} points, the scan has {len(xyz)}.",
            "Give the grid that belongs to these points.",
        )
    if grid.rows * grid.columns > EMPTY_CELLS_PER_POINT * len(xyz) + 1_000_000:
        raise UnusableGrid("nearly all cells of the grid are empty")


def _spread(lines: int) -> Ints:
    return np.unique(np.linspace(0, max(lines - 1, 0), LINES).astype(np.int64))


def _sample(grid: ScanGrid, rows: Ints, columns: Ints) -> tuple[Ints, Ints]:
    """For each sampled line, the number of a point per cell, or -1."""
    from app.core.kernels.grid import sample_lines

    row_slot, column_slot = np.full(grid.rows, -1), np.full(grid.columns, -1)
    row_slot[rows] = np.arange(len(rows))
    column_slot[columns] = np.arange(len(columns))
    in_rows = np.full((len(rows), grid.columns), -1)
    in_columns = np.full((len(columns), grid.rows), -1)
    inside = [False, False]

    def work(first: int, _: int) -> None:
        if first == 0:
            inside[0] = sample_lines(grid.row, grid.column, row_slot, in_rows)
        else:
            inside[1] = sample_lines(grid.column, grid.row, column_slot, in_columns)

    run_in_pieces(work, np.arange(3))
    if not all(inside):
        raise BadInput(
            f"A point lies outside the grid of {grid.rows} × {grid.columns} cells.",
            "The file's rows or columns are damaged.",
        )
    return in_rows, in_columns


def _measure_lines(xyz: Floats, scanner: Floats, lines: Ints) -> Floats:
    """Median angle between neighbouring cells of each line; NaN where there are no pairs."""
    low, medians, high = _quartiles(xyz, scanner, lines, 1)
    known = np.isfinite(medians)
    if not known.any():
        raise UnusableGrid("the grid has no neighbouring cells to measure its steps by")
    far = _quartiles(xyz, scanner, lines, FAR)[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        spreads = np.where(low > 0.0, high / low, np.inf)[known]
        straight = np.where(np.isfinite(far), far / medians, 1.0)[known]
    if np.median(spreads) > LARGEST_SPREAD or np.median(straight) < LEAST_STRAIGHT:
        raise UnusableGrid("rows and columns do not follow the beams from this position")
    return medians


def _quartiles(
    xyz: Floats, scanner: Floats, lines: Ints, apart: int
) -> tuple[Floats, Floats, Floats]:
    """Quartiles of the angle per cell between points `apart` filled cells apart, line by line.

    Over at most about `PAIRS` pairs of each line, and none over gaps in it; NaN: no pair.
    """
    from app.core.kernels.grid import angles_along

    angles, count = np.full((len(lines), 2 * PAIRS), np.inf), np.zeros(len(lines), np.int64)
    angles_along(xyz, scanner, lines, apart, MOST_GAP * apart, PAIRS, angles, count)
    angles.sort(axis=1)

    def quantile(share: float) -> Floats:
        place = share * np.maximum(count - 1, 0)
        below = place.astype(np.int64)
        each = np.arange(len(lines))
        one, next_one = angles[each, below], angles[each, np.minimum(below + 1, count - 1)]
        with np.errstate(invalid="ignore"):
            value: Floats = one + (place - below) * (next_one - one)
        return np.where(count > 0, value, np.nan)

    return quantile(0.25), quantile(0.5), quantile(0.75)


def _measure_noise(xyz: Floats, scanner: Floats, lines: Ints) -> float:
    """Standard deviation of the range from second differences along the lines (robust)."""
    line, cell = np.nonzero((lines[:, :-2] >= 0) & (lines[:, 1:-1] >= 0) & (lines[:, 2:] >= 0))
    thin = max(1, len(line) // (LINES * PAIRS))
    line, cell = line[::thin], cell[::thin]
    with np.errstate(invalid="ignore", over="ignore"):
        near, own, far = (
            np.linalg.norm(xyz[lines[line, cell + k]] - scanner, axis=1) for k in range(3)
        )
        bend = np.abs(near - 2.0 * own + far)
    return noise_of_bends(bend)


def noise_of_bends(bend: Floats) -> float:
    """Standard deviation of values whose second differences have these sizes (robust), or 0.

    Those that are not finite are left out.
    """
    known = bend[np.isfinite(bend)]
    return float(np.median(known) / (0.6745 * np.sqrt(6.0))) if len(known) else 0.0


def _fill(measured: Floats, lines: Ints, total: int) -> Floats:
    known = np.isfinite(measured)
    filled: Floats = np.interp(np.arange(total), lines[known], measured[known])
    return np.maximum(filled, 1e-9)


def _finds_seam(xyz: Floats, scanner: Floats, in_rows: Ints, across: Floats) -> bool:
    """Whether the first and the last columns look in neighbouring directions."""
    columns = in_rows.shape[1]
    if columns < 4 * SEAM_COLUMNS:
        return False
    first, last = in_rows[:, :SEAM_COLUMNS] >= 0, in_rows[:, columns - SEAM_COLUMNS :] >= 0
    line = np.flatnonzero(first.any(axis=1) & last.any(axis=1))
    head = first.argmax(axis=1)[line]
    tail = SEAM_COLUMNS - 1 - last[:, ::-1].argmax(axis=1)[line]
    heads = xyz[in_rows[line, head]] - scanner
    tails = xyz[in_rows[line, columns - SEAM_COLUMNS + tail]] - scanner
    gap = head + SEAM_COLUMNS - tail
    votes = angle_between(heads, tails) <= (gap + 1.5) * across[line]
    return bool(votes.sum() * 2 > len(votes))
