"""Points sorted by the cells of a scan grid, and how far a window of it must reach."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER

MARGIN = 1.02


@njit(cache=True, nogil=True)
def sample_lines(line: AnyArray, cell: AnyArray, slot: AnyArray, lines: AnyArray) -> bool:
    """Note a point for every cell of the lines that have a slot; False: a cell is outside."""
    for i in range(line.size):
        k = line[i]
        if k < 0 or k >= slot.size:
            return False
        if slot[k] >= 0:
            if cell[i] < 0 or cell[i] >= lines.shape[1]:
                return False
            lines[slot[k], cell[i]] = i
    return True


@njit(cache=True, nogil=True)
def angles_along(
    xyz: AnyArray, scanner: AnyArray, lines: AnyArray, apart: int, gap: int, pairs: int,
    angles: AnyArray, count: AnyArray,
) -> None:  # fmt: skip
    """Angle per cell between points of each line that are `apart` filled cells apart.

    About `pairs` of them, spread over the line, and none over more than `gap` cells.
    """
    filled = np.empty(lines.shape[1], np.int64)
    for k in range(lines.shape[0]):
        total = near = 0
        for c in range(lines.shape[1]):
            if lines[k, c] >= 0:
                filled[total] = c
                total += 1
                near += total > apart and c - filled[total - 1 - apart] <= gap
        step, seen = max(1, near // pairs), 0
        for m in range(apart, total):
            if filled[m] - filled[m - apart] > gap:
                continue
            if seen % step == 0:
                angle = angle_per_cell(xyz, scanner, lines, k, filled[m - apart], filled[m])
                if angle < math.inf:
                    angles[k, count[k]] = angle
                    count[k] += 1
            seen += 1


@njit(**INNER)
def angle_per_cell(
    xyz: AnyArray, scanner: AnyArray, lines: AnyArray, k: int, one: int, other: int
) -> float:
    """Angle between the beams of two cells of line k, over their distance; inf: unknown."""
    p, q = lines[k, one], lines[k, other]
    ax, ay, az = xyz[p, 0] - scanner[0], xyz[p, 1] - scanner[1], xyz[p, 2] - scanner[2]
    bx, by, bz = xyz[q, 0] - scanner[0], xyz[q, 1] - scanner[1], xyz[q, 2] - scanner[2]
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    dot = ax * bx + ay * by + az * bz
    sizes = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    if not (0.0 < sizes < math.inf):
        return math.inf
    return math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), dot) / (other - one)


@njit(cache=True, nogil=True)
def half_window(
    r: int, angle: float, down: float, across: AnyArray, columns: int
) -> tuple[int, int]:
    """Rows and columns on either side that a cone of half-angle `angle` can touch.

    `down` is the angle from row to row, `across` holds that from column to column for each
    row. Columns meet at a pole: there the window takes them all.
    """
    rows = across.size
    high = rows
    if angle * MARGIN < down * rows:
        high = min(rows, int(angle * MARGIN / down) + 1)
    step = min(across[r], across[max(r - high, 0)], across[min(r + high, rows - 1)])
    wide = columns
    if angle * MARGIN < step * columns:
        wide = int(angle * MARGIN / step) + 1
        if wide > columns // 12:
            # Not far from a pole the arc is longer than the angle, up to π/2 times.
            wide = min(columns, int(angle * MARGIN / step * 1.6) + 1)
    return high, wide


@njit(cache=True, nogil=True)
def mark_tiles(
    xyz: AnyArray, row: AnyArray, column: AnyArray, points: AnyArray, scanner: AnyArray,
    down: AnyArray, across: AnyArray, seam: bool, widths: AnyArray, cells: int, least: int,
    tile: int, marks: AnyArray,
) -> None:  # fmt: skip
    """Mark the tiles that the windows of the asked points can touch."""
    rows, columns = across.size, down.size
    for i in points:
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        if not (0.0 < distance < math.inf):
            continue
        r, c = row[i], column[i]
        high, wide = least, least
        for k in range(widths.size):
            h, w = half_window(
                r, math.asin(min(1.0, widths[k] / distance)), down[c], across, columns
            )
            if k > 0 and (2 * h + 1) * (2 * w + 1) > cells:
                break
            high, wide = max(high, h), max(wide, w)
        if seam and (c < wide or c + wide >= columns):
            wide = columns
        for tr in range(max(r - high, 0) // tile, min(r + high, rows - 1) // tile + 1):
            for tc in range(max(c - wide, 0) // tile, min(c + wide, columns - 1) // tile + 1):
                marks[tr, tc] = True


@njit(cache=True, nogil=True)
def sort_by_cell(
    xyz: AnyArray, row: AnyArray, column: AnyArray, scanner: AnyArray, marks: AnyArray, tile: int,
    columns: int, start: AnyArray,
) -> tuple[AnyArray, AnyArray, AnyArray, AnyArray]:  # fmt: skip
    """Counting sort of the usable points in marked tiles by cell; fills `start` (cells + 2).

    Returns x, y, z and the point's number, cell by cell; the points of cell k are
    start[k] to start[k + 1].
    """
    kept = np.empty(row.size, np.bool_)
    for i in range(row.size):
        kept[i] = False
        if marks[row[i] // tile, column[i] // tile]:
            dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
            if 0.0 < dx * dx + dy * dy + dz * dz < math.inf:
                kept[i] = True
                start[np.int64(row[i]) * columns + column[i] + 2] += 1
    for k in range(1, start.size):
        start[k] += start[k - 1]
    total = start[start.size - 1]
    x, y, z = np.empty(total), np.empty(total), np.empty(total)
    member = np.empty(total, np.int64)
    for i in range(row.size):
        if kept[i]:
            cell = np.int64(row[i]) * columns + column[i] + 1
            place = start[cell]
            start[cell] += 1
            x[place], y[place], z[place] = xyz[i, 0], xyz[i, 1], xyz[i, 2]
            member[place] = i
    return x, y, z, member
