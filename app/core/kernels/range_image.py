"""The scan as the scanner saw it: one over the range, and the number of the point, by cell."""

import math

from numba import njit

from app.core.arrays import AnyArray


@njit(cache=True, nogil=True, error_model="numpy")
def fill_image(
    xyz: AnyArray, row: AnyArray, column: AnyArray, scanner: AnyArray, marks: AnyArray, tile: int,
    always: AnyArray, first: int, last: int, inverse: AnyArray, number: AnyArray,
) -> tuple[int, int]:  # fmt: skip
    """Fill `inverse` (1 / range) and `number` (of the point, from 1) in the rows first to last.

    Only cells of marked tiles, and of the rows that `always` names, are filled. Of several
    points in a cell the nearest is kept. Returns how many cells were filled, and how
    many points lie outside the grid.

    Threads share the rows, not the points: two points of one cell meet in one thread.
    """
    rows, columns = number.shape
    filled = outside = 0
    for i in range(row.size):
        r = row[i]
        if r < first or r >= last:
            outside += (r < 0) | (r >= rows)
            continue
        c = column[i]
        if c < 0 or c >= columns:
            outside += 1
            continue
        if not (marks[r // tile, c // tile] or always[r]):
            continue
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        square = dx * dx + dy * dy + dz * dz
        if not (0.0 < square < math.inf):
            continue
        w = 1.0 / math.sqrt(square)
        if number[r, c] == 0:
            filled += 1
        elif w <= inverse[r, c]:
            continue
        inverse[r, c] = w
        number[r, c] = i + 1
    return filled, outside
