"""Planes over undisturbed windows of a tile: 1 / range is linear in row and column.

For a plane n · P = h and a beam of direction u, 1 / r = (n · u) / h. Over a small window that is
linear in row and column, and the noise, which lies along the beam, is the same everywhere in it.
"""

import math

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.tiles import gate
from app.core.normals.rules import HALO, REACH

UPS = np.array([1, -1, 0, 0, 1, 1, -1, -1])
SIDES = np.array([0, 0, 1, -1, 1, -1, 1, -1])
"""Above, below, left and right of a cell, then the quarters."""
PARTS = np.array([0.0] + [3.0 / (h * (h + 1)) for h in range(1, HALO + 1)])
"""Three over h (h + 1): with 1 / n it is one over the spread of h cells on either side."""
NOISE = 2.0
"""Times the measured variance that a residual is no longer noise alone."""
NOTHING = (0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""No fit. Otherwise: cells, half-width in rows and in columns, where the window's middle lies
from the cell (rows, columns), value at the cell, slopes by row and by column, their variances
and covariance, squared residual."""


@njit(**INNER, forceinline=True)
def half_cells(width, w, down, side):  # type: ignore[no-untyped-def]
    """Rows and columns to either side that a half-width reaches at 1 / range; at least one."""
    high = int(width * w / abs(down) + 0.5)
    wide = int(width * w / abs(side) + 0.5)
    return max(1, min(high, REACH)), max(1, min(wide, REACH))


@njit(**INNER, forceinline=True)
def fit_rectangle(s, top, bottom, left, right, i, j):  # type: ignore[no-untyped-def]
    """Plane over a rectangle: cells, value at (i, j), slopes, spreads, squared residual."""
    tall, wide = bottom - top, right - left
    n = float(tall * wide)
    total = s[bottom, right, 0] - s[top, right, 0] - s[bottom, left, 0] + s[top, left, 0]
    by_row = s[bottom, right, 1] - s[top, right, 1] - s[bottom, left, 1] + s[top, left, 1]
    by_side = s[bottom, right, 2] - s[top, right, 2] - s[bottom, left, 2] + s[top, left, 2]
    square = s[bottom, right, 3] - s[top, right, 3] - s[bottom, left, 3] + s[top, left, 3]
    mi, mj = 0.5 * (top + bottom - 1), 0.5 * (left + right - 1)
    by_row -= mi * total
    by_side -= mj * total
    spread_i, spread_j = n * (tall * tall - 1) / 12.0, n * (wide * wide - 1) / 12.0
    mean, a, b = total / n, by_row / spread_i, by_side / spread_j
    rest = max(square - total * mean - a * by_row - b * by_side, 0.0) / max(n - 3.0, 1.0)
    return n, mean + a * (i - mi) + b * (j - mj), a, b, spread_i, spread_j, rest


@njit(**INNER, forceinline=True)
def fit_undisturbed(tile, base, i, j, down, side, most, rules):  # type: ignore[no-untyped-def]
    """The widest undisturbed window that agrees with all narrower ones (Lepski's rule)."""
    s, bad, widths, agree = tile.sums, tile.bad, rules.widths, rules.agree
    w = tile.w[i, j] + base
    per_row, per_side = w / abs(down), w / abs(side)
    noise = NOISE * (rules.noise * w * w) ** 2
    low_i = low_j = -np.inf
    high_i = high_j = np.inf
    high = wide = 0
    mean = a = b = square = first = 0.0
    for k in range(most):
        tall = max(1, min(int(widths[k] * per_row + 0.5), REACH))
        broad = max(1, min(int(widths[k] * per_side + 0.5), REACH))
        if tall == high and broad == wide:
            continue
        top, bottom, left, right = i - tall, i + tall + 1, j - broad, j + broad + 1
        if bad[bottom, right] - bad[top, right] - bad[bottom, left] + bad[top, left] != 0:
            break
        n = (2.0 * tall + 1.0) * (2.0 * broad + 1.0)
        total = s[bottom, right, 0] - s[top, right, 0] - s[bottom, left, 0] + s[top, left, 0]
        by_row = s[bottom, right, 1] - s[top, right, 1] - s[bottom, left, 1] + s[top, left, 1]
        by_side = s[bottom, right, 2] - s[top, right, 2] - s[bottom, left, 2] + s[top, left, 2]
        power = s[bottom, right, 3] - s[top, right, 3] - s[bottom, left, 3] + s[top, left, 3]
        by_row -= i * total
        by_side -= j * total
        per_n = 1.0 / n
        part_i, part_j = PARTS[tall] * per_n, PARTS[broad] * per_n
        slope_i, slope_j = by_row * part_i, by_side * part_j
        rest = power - total * total * per_n - slope_i * by_row - slope_j * by_side
        rest = max(rest, 0.0) / max(n - 3.0, 1.0)
        if high == 0:
            first = rest
        # A window over a bend has a large residual, which must not excuse the bend.
        known = min(rest, 1.7 * first, noise)
        error_i, error_j = agree * math.sqrt(known * part_i), agree * math.sqrt(known * part_j)
        low_i, high_i = max(low_i, slope_i - error_i), min(high_i, slope_i + error_i)
        low_j, high_j = max(low_j, slope_j - error_j), min(high_j, slope_j + error_j)
        if low_i > high_i or low_j > high_j:
            break
        high, wide, mean, a, b, square = tall, broad, total * per_n, slope_i, slope_j, rest
    if high == 0:
        return NOTHING
    n = (2 * high + 1) * (2 * wide + 1)
    return (
        n, high, wide, 0.0, 0.0, mean, a, b,
        square * PARTS[high] / n, square * PARTS[wide] / n, 0.0, square,
    )  # fmt: skip


@njit(**INNER, forceinline=True)
def fit_beside(tile, base, i, j, down, side, rules):  # type: ignore[no-untyped-def]
    """Plane over the undisturbed half or quarter window nearest to a cell beside a jump.

    Of those equally near, the one that foretells the cell's own range best; none if it is no
    plane but for the noise.
    """
    s, bad = tile.sums, tile.bad
    own = tile.w[i, j]
    w = own + base
    high, wide = half_cells(rules.beside, w, down, side)
    high, wide = max(high, 2), max(wide, 2)
    limit = gate(1.0 / w, max(abs(down), abs(side)), rules.slope, rules.jump * rules.noise) * w * w
    best = NOTHING
    for away in range(rules.away):
        nearest = limit
        for k in range(8):
            up, aside = UPS[k], SIDES[k]
            # The rectangle's own edge lies `away` cells from the cell, or around it.
            top = i - high if up == 0 else (i - away - high if up > 0 else i + away)
            left = j - wide if aside == 0 else (j - away - wide if aside > 0 else j + away)
            bottom = top + (2 * high + 1 if up == 0 else high + 1)
            right = left + (2 * wide + 1 if aside == 0 else wide + 1)
            if bad[bottom, right] - bad[top, right] - bad[bottom, left] + bad[top, left] != 0:
                continue
            n, value, a, b, spread_i, spread_j, rest = fit_rectangle(
                s, top, bottom, left, right, i, j
            )
            # A quarter is half as sure as a half.
            off = abs(value - own) * (1.0 if k < 4 else 2.0)
            if off < nearest:
                nearest = off
                best = (
                    int(n), high, wide, 0.5 * (top + bottom - 1) - i, 0.5 * (left + right - 1) - j,
                    value, a, b, rest / spread_i, rest / spread_j, 0.0, rest,
                )  # fmt: skip
        if best[0] > 0:
            break
    return best if best[11] <= rules.calm_beside * (rules.noise * w * w) ** 2 else NOTHING
