"""Rows and columns as the scanner sees them: which way is up, and what angle a line has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.neighbours.steps import ScanGrid

SAMPLES = 200_000
FINEST, PER_SQUARE = 256, 8
PER_PIXEL = 2.0
"""Points in a pixel of a cloud without a grid: fewer would leave holes all over."""


@dataclass(frozen=True, slots=True)
class Turn:
    """How a scan grid is turned so that row 0 is the highest and column 0 the leftmost.

    Attributes
    ----------
    rows, columns : int
        After turning.
    swapped : bool
        Rows became columns, before anything was flipped.
    flipped : (bool, bool)
        Rows and columns are counted from the other end.
    """

    rows: int
    columns: int
    swapped: bool = False
    flipped: tuple[bool, bool] = (False, False)

    def place(self, row: AnyArray, column: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Where cells of the grid lie after turning."""
        return self._flip(column, row) if self.swapped else self._flip(row, column)

    def find_cell(self, row: int, column: int) -> tuple[int, int]:
        """Row and column in the grid of what lies there after turning."""
        found = self._flip(np.array(row), np.array(column))
        first, second = (int(part) for part in found)
        return (second, first) if self.swapped else (first, second)

    def _flip(self, row: AnyArray, column: AnyArray) -> tuple[AnyArray, AnyArray]:
        return (
            self.rows - 1 - row if self.flipped[0] else row,
            self.columns - 1 - column if self.flipped[1] else column,
        )


def turn_upright(grid: ScanGrid, azimuth: AnyArray, elevation: AnyArray) -> Turn:
    """Find how to turn a grid: files count from either end, and some count azimuth in rows.

    Parameters
    ----------
    grid : ScanGrid
    azimuth, elevation : (n,) degrees
        NaN where there is no direction.
    """
    some = np.flatnonzero(np.isfinite(azimuth))[:: max(1, len(azimuth) // SAMPLES)]
    row, column = np.asarray(grid.row)[some], np.asarray(grid.column)[some]
    height, turn = elevation[some].astype(np.float64), azimuth[some].astype(np.float64)
    rows, columns = int(grid.rows), int(grid.columns)
    # Along a line of azimuth the elevation changes, along one of elevation it stays.
    swapped = _spread(height, row, rows) > _spread(height, column, columns)
    if swapped:
        row, column, rows, columns = column, row, columns, rows
    heights = follow_lines(height, row, rows)
    turns = follow_lines(turn, column, columns, turns=True)
    flipped = (bool(heights[-1] > heights[0]), bool(turns[-1] > turns[0]))
    return Turn(rows, columns, swapped, flipped)


def follow_lines(angle: AnyArray, line: AnyArray, lines: int, turns: bool = False) -> Floats:
    """Mean angle of each line, degrees; lines without points lie evenly between the others.

    With `turns` angles are those of a circle, and are followed beyond ±180°.
    """
    count = np.bincount(line, minlength=lines)
    known = np.flatnonzero(count)
    if len(known) == 0:
        return np.zeros(lines)
    if turns:
        around = np.deg2rad(angle)
        east, north = (np.bincount(line, part(around), lines)[known] for part in (np.cos, np.sin))
        mean = np.rad2deg(np.unwrap(np.arctan2(north, east)))
    else:
        mean = np.bincount(line, angle, lines)[known] / count[known]
    step = (mean[-1] - mean[0]) / max(known[-1] - known[0], 1)
    every = np.arange(lines)
    filled: Floats = np.interp(every, known, mean)
    filled[: known[0]] = mean[0] + step * (every[: known[0]] - known[0])
    filled[known[-1] :] = mean[-1] + step * (every[known[-1] :] - known[-1])
    return filled


def unroll(azimuth: AnyArray) -> tuple[Floats, float]:
    """Degrees to the right of the middle of the widest gap, and the azimuth where they begin."""
    if len(azimuth) == 0:
        return np.empty(0), 0.0
    known = np.unique(np.round(azimuth.astype(np.float64), 2))
    gaps = np.diff(np.append(known, known[0] + 360.0))
    after = int(np.argmax(gaps))
    # Columns run to the right, azimuths to the left: the picture begins below the gap.
    turn = (known[after] - azimuth.astype(np.float64)) % 360.0
    turn[turn > 360.0 - 0.02] = 0.0  # what rounding put on the wrong side of the gap
    least = float(turn.min())
    return turn - least, float(known[after]) - least


def set_step(turn: Floats, fall: Floats, most: int) -> float:
    """Side of a pixel in degrees, so that most pixels that are seen hold points."""
    if len(turn) == 0:
        return 1.0
    wide, high = float(turn.max()), float(fall.max())
    across, down = max(wide, 1e-6), max(high, 1e-6)
    # Squares so coarse that hardly one of those that the scanner saw is empty by chance.
    side = int(np.clip(np.sqrt(len(turn) / PER_SQUARE), 1, FINEST))
    place = np.minimum((fall / down * side).astype(np.int64), side - 1) * side
    place += np.minimum((turn / across * side).astype(np.int64), side - 1)
    filled = np.count_nonzero(np.bincount(place, minlength=side**2)) / side**2
    seen = np.sqrt(filled * across * down * PER_PIXEL / len(turn))
    return float(max(seen, np.sqrt(across * down / most) * 1.01, max(across, down) / 16_384))


def _spread(angle: Floats, line: AnyArray, lines: int) -> float:
    """Mean square distance of angles from the mean of their line."""
    count = np.maximum(np.bincount(line, minlength=lines), 1)
    mean = np.bincount(line, angle, lines) / count
    return float(np.mean((angle - mean[line]) ** 2)) if len(angle) else 0.0
