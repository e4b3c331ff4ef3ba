"""Points sorted by the cells of a scan grid, and planes from windows of it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import SAFE
from app.core.kernels.plane import SUMS, add_ball, covers_area, store_plane

MOST_PER_ROW = 512
MARGIN = 1.02


@njit(cache=True, nogil=True)
def sample_lines(
    row: AnyArray,
    column: AnyArray,
    row_slot: AnyArray,
    column_slot: AnyArray,
    in_rows: AnyArray,
    in_columns: AnyArray,
) -> bool:
    """Note a point for every cell of the sampled rows and columns; False: a cell is outside."""
    rows, columns = row_slot.size, column_slot.size
    for i in range(row.size):
        r, c = row[i], column[i]
        if r < 0 or c < 0 or r >= rows or c >= columns:
            return False
        if row_slot[r] >= 0:
            in_rows[row_slot[r], c] = i
        if column_slot[c] >= 0:
            in_columns[column_slot[c], r] = i
    return True


@njit(cache=True, nogil=True)
def half_window(r: int, c: int, angle: float, down: AnyArray, across: AnyArray) -> tuple[int, int]:
    """Rows and columns on either side that a cone of half-angle `angle` can touch.

    `down` holds the angle from row to row for each column, `across` that from column to
    column for each row. Columns meet at a pole: there the window takes them all.
    """
    rows, columns = across.size, down.size
    high = rows
    if angle * MARGIN < down[c] * rows:
        high = min(rows, int(angle * MARGIN / down[c]) + 1)
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
            h, w = half_window(r, c, math.asin(min(1.0, widths[k] / distance)), down, across)
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


@njit(cache=True, nogil=True, fastmath=SAFE)
def sum_window(
    x: AnyArray, y: AnyArray, z: AnyArray, start: AnyArray, rows: int, columns: int, seam: bool,
    r: int, c: int, high: int, wide: int, px: float, py: float, pz: float, limit: float,
    sums: AnyArray,
) -> None:  # fmt: skip
    """Sum the ball over a window; a row's cells lie side by side in memory."""
    sums[:] = 0.0
    step = max(1, (2 * wide + 1) // MOST_PER_ROW)
    left, right = c - wide, c + wide + 1
    if right - left >= columns:
        left, right = 0, columns
    for line in range(max(r - high, 0), min(r + high, rows - 1) + 1):
        base = line * columns
        add_ball(
            x, y, z, start[base + max(left, 0)], start[base + min(right, columns)], step,
            px, py, pz, limit, sums,
        )  # fmt: skip
        if seam and left < 0:
            add_ball(
                x, y, z, start[base + left + columns], start[base + columns], step,
                px, py, pz, limit, sums,
            )  # fmt: skip
        if seam and right > columns:
            add_ball(
                x, y, z, start[base], start[base + right - columns], step,
                px, py, pz, limit, sums,
            )  # fmt: skip


@njit(cache=True, nogil=True)
def fit_in_windows(
    x: AnyArray, y: AnyArray, z: AnyArray, member: AnyArray, start: AnyArray, row: AnyArray,
    column: AnyArray, slot: AnyArray, first: int, last: int, scanner: AnyArray, down: AnyArray,
    across: AnyArray, seam: bool, widths: AnyArray, enough: int, cells: int, normals: AnyArray,
    count: AnyArray, width: AnyArray, rms: AnyArray,
) -> None:  # fmt: skip
    """Planes of the sorted points `first` to `last`, written to the slots of those asked for.

    The ball grows through `widths` until it holds `enough` points, or until its window has
    more than `cells` cells: a point that finds no support in so many beams lies on nothing.
    """
    rows, columns = across.size, down.size
    sums = np.empty(SUMS)
    for p in range(first, last):
        i = member[p]
        k = slot[i]
        if k < 0:
            continue
        px, py, pz = x[p], y[p], z[p]
        dx, dy, dz = px - scanner[0], py - scanner[1], pz - scanner[2]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        defined = False
        for g in range(widths.size):
            angle = math.asin(min(1.0, widths[g] / distance))
            high, wide = half_window(row[i], column[i], angle, down, across)
            if g > 0 and (2 * high + 1) * (2 * wide + 1) > cells:
                break
            sum_window(
                x, y, z, start, rows, columns, seam, row[i], column[i], high, wide,
                px, py, pz, widths[g] * widths[g], sums,
            )  # fmt: skip
            count[k] = int(sums[0])
            width[k] = widths[g]
            defined = covers_area(sums, px, py, pz, scanner, widths[g])
            if sums[0] >= enough and defined:
                break
        if defined:
            rms[k] = store_plane(sums, px, py, pz, scanner, normals[k])
