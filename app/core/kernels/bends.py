"""How much a surface bends around, from the planes of windows side by side.

A window whose middle lies off the cell sees another slope than the cell's; one over a wrinkle
sees a flatter slope. Both errors come from the surface, not from noise, and no residual of the
window itself tells them: its neighbours do.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.windows import fit_rectangle, half_cells
from app.core.normals.rules import HALO

BLOCK = 16
"""Cells of a side over which bends are averaged (with the blocks around it)."""
EVERY = 8
"""Cells from one measurement to the next."""
MOST_HALF = (HALO - 1) // 3
"""Cells to either side, so that three windows fit into the halo."""
FEWEST = 3
"""Measurements that a mean needs."""
USUAL = 0.02
"""Radians of bend within a radius, where none can be measured: at 4 mm that of a leaf bent with
a radius of 20 cm."""


class Bends(NamedTuple):
    """By block: squared change of slope per angle, and squared change of that between windows."""

    sums: Any  # (blocks, blocks, 3): of both, and how many
    means: Any  # (blocks, blocks, 2): over a block and those around it


@njit(**INNER)
def make_bends(size):  # type: ignore[no-untyped-def]
    """Memory for the blocks of a tile of size × size cells, without its halo."""
    n = size // BLOCK
    return Bends(np.zeros((n, n, 3)), np.zeros((n, n, 2)))


@njit(**INNER)
def measure_bends(image, tile, base, place, width, bends):  # type: ignore[no-untyped-def]
    """Compare windows of the half-width side by side, all over a tile."""
    down, turn, level = image.down, image.turn, image.level
    w = tile.w
    for block in np.ndindex(bends.sums.shape):
        bends.sums[block] = 0.0
    for r in range(place[0], place[2], EVERY):
        i = r - place[0] + HALO
        for c in range(place[1], place[3], EVERY):
            j = c - place[1] + HALO
            if tile.marks[i, j]:
                continue
            side = turn[c] * level[r]
            high, wide = half_cells(width, w[i, j] + base, down[r], side)
            high, wide = min(high, MOST_HALF), min(wide, MOST_HALF)
            compare(tile, base, i, j, high, wide, down[r], side, True, bends)
            compare(tile, base, i, j, high, wide, down[r], side, False, bends)
    average_bends(bends, width * base)


@njit(**INNER)
def compare(tile, base, i, j, high, wide, down, side, upright, bends):  # type: ignore[no-untyped-def]
    """Add what the windows above and below a cell, or left and right of it, say of its bend."""
    s, bad = tile.sums, tile.bad
    di, dj = (2 * high + 1, 0) if upright else (0, 2 * wide + 1)
    apart = di * abs(down) + dj * abs(side)
    up = np.zeros(3)
    left = np.zeros(3)
    noise = 0.0
    for k in range(3):
        y, x = i + (k - 1) * di, j + (k - 1) * dj
        top, bottom, begin, end = y - high, y + high + 1, x - wide, x + wide + 1
        if bad[bottom, end] - bad[top, end] - bad[bottom, begin] + bad[top, begin] != 0:
            return
        fit = fit_rectangle(s, top, bottom, begin, end, y, x)
        # Relative to 1 / range: an angle by angle, whatever the distance.
        w = fit[1] + base
        up[k], left[k] = fit[2] / (down * w), fit[3] / (side * w)
        noise += fit[6] / (w * w) * (1.0 / (fit[4] * down * down) + 1.0 / (fit[5] * side * side))
    y, x = (i - HALO) // BLOCK, (j - HALO) // BLOCK
    change = 0.5 * ((up[2] - up[0]) ** 2 + (left[2] - left[0]) ** 2) - noise / 3.0
    bends.sums[y, x, 0] += change / (4.0 * apart * apart)
    turn = 0.5 * ((up[2] - 2 * up[1] + up[0]) ** 2 + (left[2] - 2 * left[1] + left[0]) ** 2)
    bends.sums[y, x, 1] += turn - noise
    bends.sums[y, x, 2] += 1.0


@njit(**INNER)
def average_bends(bends, reach):  # type: ignore[no-untyped-def]
    """Means over each block and those around it; the usual bend where there is too little."""
    sums, means = bends.sums, bends.means
    n = sums.shape[0]
    usual = (USUAL / reach) ** 2 if reach > 0.0 else 0.0
    for y in range(n):
        for x in range(n):
            first = second = count = 0.0
            for a in range(max(y - 1, 0), min(y + 2, n)):
                for b in range(max(x - 1, 0), min(x + 2, n)):
                    first += sums[a, b, 0]
                    second += sums[a, b, 1]
                    count += sums[a, b, 2]
            known = count >= FEWEST
            means[y, x, 0] = max(first / count, 0.0) if known else usual
            means[y, x, 1] = max(second / count, 0.0) if known else 0.0


@njit(**INNER, forceinline=True)
def mean_bends(bends, i, j):  # type: ignore[no-untyped-def]
    """Squared change of slope by angle, and of its change from window to window, around a cell.

    Between the middles of blocks it is interpolated: σ must not show squares.
    """
    means = bends.means
    last = means.shape[0] - 1
    y = min(max((i - HALO + 0.5) / BLOCK - 0.5, 0.0), last - 0.001)
    x = min(max((j - HALO + 0.5) / BLOCK - 0.5, 0.0), last - 0.001)
    a, b = int(y), int(x)
    v, u = y - a, x - b
    p, q, r, s = (1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u
    return (
        p * means[a, b, 0] + q * means[a, b + 1, 0] + r * means[a + 1, b, 0]
        + s * means[a + 1, b + 1, 0],
        p * means[a, b, 1] + q * means[a, b + 1, 1] + r * means[a + 1, b, 1]
        + s * means[a + 1, b + 1, 1],
    )  # fmt: skip
