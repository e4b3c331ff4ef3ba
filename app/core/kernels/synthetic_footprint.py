"""Sums over circles of beams, row by row, from running sums along the rows."""

import math

from numba import njit

from app.core.kernels import SAFE

INLINE = {"cache": True, "nogil": True, "error_model": "numpy", "forceinline": True}


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SAFE)
def sum_discs(sums, elevation, level, azimuth, step, seam, row, column, half, found):  # type: ignore[no-untyped-def]
    """Sum every layer over the cells within an angle `half` of each cell asked for.

    `sums` (rows, columns + 1, layers) are running sums along the rows, `level` the cosines of the
    elevation, `found` (k, layers).
    """
    rows, columns, layers = sums.shape[0], sums.shape[1] - 1, sums.shape[2]
    for p in range(len(row)):
        for layer in range(layers):
            found[p, layer] = 0.0
        if not half[p] >= 0.0:
            continue
        i, j = row[p], column[p]
        pace = 1.0 / abs(step[j])
        reach = math.sin(0.5 * half[p]) ** 2
        for way in (-1, 1):
            k = i if way > 0 else i - 1
            while 0 <= k < rows:
                lift = math.sin(0.5 * (elevation[k] - elevation[i])) ** 2
                if lift > reach:
                    break
                flat = level[k] * level[i]
                share = (reach - lift) / flat if flat > 0.0 else 1.0
                turn = math.pi if share >= 1.0 else 2.0 * math.asin(math.sqrt(share))
                right = reach_columns(azimuth, seam, j, turn, 1, pace, columns)
                left = reach_columns(azimuth, seam, j, turn, -1, pace, columns)
                if left + right + 1 >= columns:
                    left, right = j, columns - 1 - j
                add_between(sums[k], j - left, j + right + 1, found[p])
                k += way


@njit(**INLINE)
def add_between(line, low, high, found):  # type: ignore[no-untyped-def]
    """Add the cells from `low` to before `high`, across the seam where they go beyond."""
    columns = len(line) - 1
    for layer in range(len(found)):
        total = line[min(high, columns), layer] - line[max(low, 0), layer]
        if low < 0:
            total += line[columns, layer] - line[columns + low, layer]
        if high > columns:
            total += line[high - columns, layer]
        found[layer] += total


@njit(**INLINE)
def reach_columns(azimuth, seam, j, turn, way, pace, columns):  # type: ignore[no-untyped-def]
    """How many columns to one side lie within `turn` of column j."""
    most = columns - 1 if seam else (columns - 1 - j if way > 0 else j)
    count = min(int(turn * pace), most)
    while count > 0 and distance(azimuth, j, j + way * count, columns) > turn:
        count -= 1
    while count < most and distance(azimuth, j, j + way * (count + 1), columns) <= turn:
        count += 1
    return count


@njit(**INLINE)
def distance(azimuth, j, other, columns):  # type: ignore[no-untyped-def]
    """Azimuth between two columns; beyond the seam it goes on after a whole turn."""
    if 0 <= other < columns:
        return abs(azimuth[other] - azimuth[j])
    if other >= columns:
        return 2.0 * math.pi - abs(azimuth[other - columns] - azimuth[j])
    return 2.0 * math.pi - abs(azimuth[other + columns] - azimuth[j])
