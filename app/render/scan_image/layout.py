"""Where each point lies in the picture of what the scanner saw."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.chunks import run_in_pieces, split_evenly
from app.core.neighbours.steps import ScanGrid
from app.core.progress import QUIET, Progress
from app.model.neighbours import neighbours_of
from app.model.scan import Scan
from app.render.scan_image.directions import Turn, follow_lines, set_step, turn_upright, unroll

Kind = Literal["scan grid", "recovered grid", "angles"]
MOST_PIXELS = 4_000_000
"""A few times what a screen shows: larger grids have several cells to a pixel."""
PIECE = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Rows and columns of the picture, and the pixel of each point.

    Attributes
    ----------
    rows, columns : int
        Row 0 is the highest, column 0 the leftmost as the scanner sees it.
    pixel : (n,) int32
        row · columns + column; −1 for points without a direction.
    distance : (n,) float32
        Metres from the scanner.
    elevation, azimuth : (rows,) and (columns,)
        Degrees; azimuth counts from +x towards +y, and so falls to the right.
    no_return : (rows, columns) bool
        Pixels in which the file records beams without an echo.
    kind : {'scan grid', 'recovered grid', 'angles'}
        What rows and columns are; without a grid they are equal steps of the angles.
    turn : Turn
        From the scan grid to the picture.
    merged : int
        Cells of the scan grid along each side of a pixel.
    """

    rows: int
    columns: int
    pixel: AnyArray
    distance: AnyArray
    elevation: Floats
    azimuth: Floats
    no_return: Bools
    kind: Kind
    turn: Turn
    merged: int = 1

    def find_cell(self, row: int, column: int) -> tuple[int, int]:
        """Row and column in the scan grid of the upper left cell of a pixel."""
        return self.turn.find_cell(row * self.merged, column * self.merged)

    @property
    def shape(self) -> float:
        """Width of a pixel over its height, as the scanner sees the middle of the picture."""
        down = _mean_step(self.elevation)
        across = _mean_step(self.azimuth) * math.cos(math.radians(float(self.elevation.mean())))
        return float(np.clip(across / down, 0.1, 10.0)) if down > 0 and across > 0 else 1.0


def lay_out(scan: Scan, progress: Progress = QUIET) -> Layout:
    """Find the pixel of each point: by the grid of the scan, a recovered one, or by angles.

    Raises
    ------
    MissingScanner
        The position of the scanner is unknown.
    Cancelled
    """
    scanner = scan.scanner("the scan image")
    neighbours = neighbours_of(scan, progress.part(0.0, 0.6))
    azimuth, elevation, distance = _look(scan, scanner, progress.part(0.6, 0.9))
    if neighbours.grid is None:
        return _lay_by_angles(azimuth, elevation, distance)
    kind: Kind = "scan grid" if scan.grid is not None else "recovered grid"
    return _lay_by_cells(neighbours.grid, scan, (azimuth, elevation, distance), kind)


def _look(
    scan: Scan, scanner: Floats, progress: Progress
) -> tuple[AnyArray, AnyArray, AnyArray]:  # fmt: skip
    """Azimuth and elevation (degrees) and distance (metres) of each point, float32."""
    found = np.empty((3, len(scan)), np.float32)

    def work(first: int, last: int) -> None:
        beam = scan.xyz[first:last] - scanner
        with np.errstate(invalid="ignore", over="ignore"):
            flat = np.hypot(beam[:, 0], beam[:, 1])
            found[0, first:last] = np.rad2deg(np.arctan2(beam[:, 1], beam[:, 0]))
            found[1, first:last] = np.rad2deg(np.arctan2(beam[:, 2], flat))
            found[2, first:last] = np.hypot(flat, beam[:, 2])

    run_in_pieces(work, split_evenly(len(scan), PIECE), progress, "directions")
    # Nothing lies at the scanner itself; NaN fails the comparison as well.
    with np.errstate(invalid="ignore"):
        found[:, ~((found[2] > 0) & np.isfinite(found[2]))] = np.nan
    return found[0], found[1], found[2]


def _lay_by_cells(
    grid: ScanGrid, scan: Scan, seen: tuple[AnyArray, AnyArray, AnyArray], kind: Kind
) -> Layout:
    azimuth, elevation, distance = seen
    turn, merged = turn_upright(grid, azimuth, elevation), 1
    while -(-turn.rows // merged) * -(-turn.columns // merged) > MOST_PIXELS:
        merged += 1
    rows, columns = -(-turn.rows // merged), -(-turn.columns // merged)
    cells = turn.place(np.asarray(grid.row), np.asarray(grid.column))
    row, column = (cell // merged for cell in cells)
    there = np.isfinite(distance)
    there &= (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    pixel = np.where(there, row * np.int32(columns) + column, -1).astype(np.int32)
    no_return = np.zeros((rows, columns), bool)
    if scan.grid is not None and len(scan.grid.no_return):
        silent = turn.place(*np.divmod(scan.grid.no_return, scan.grid.columns))
        no_return[silent[0] // merged, silent[1] // merged] = True
    return Layout(
        rows,
        columns,
        pixel,
        distance,
        follow_lines(elevation[there], row[there], rows),
        follow_lines(azimuth[there], column[there], columns, turns=True),
        no_return,
        kind,
        turn,
        merged,
    )


def _lay_by_angles(azimuth: AnyArray, elevation: AnyArray, distance: AnyArray) -> Layout:
    there = np.isfinite(distance)
    turn, start = unroll(azimuth[there])
    height = elevation[there]
    top = float(height.max()) if len(height) else 0.0
    fall = top - height
    step = set_step(turn, fall, MOST_PIXELS)
    row, column = (fall / step).astype(np.int32), (turn / step).astype(np.int32)
    rows, columns = (int(line.max()) + 1 if len(line) else 1 for line in (row, column))
    below, right = (step * (np.arange(lines, dtype=np.float64) + 0.5) for lines in (rows, columns))
    pixel = np.full(len(distance), -1, np.int32)
    pixel[there] = row * np.int32(columns) + column
    return Layout(
        rows,
        columns,
        pixel,
        distance,
        top - below,
        start - right,
        np.zeros((rows, columns), bool),
        "angles",
        Turn(rows, columns),
    )


def _mean_step(angles: Floats) -> float:
    return abs(float(angles[-1] - angles[0])) / (len(angles) - 1) if len(angles) > 1 else 0.0
