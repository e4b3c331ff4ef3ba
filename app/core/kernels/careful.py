"""Planes over windows with jumps or holes in them, cell by cell.

Cells outside a gate about the own range do not count; those off the surface count less and
less (iteratively reweighted least squares with Tukey's biweight).
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER, SAFE
from app.core.kernels.tiles import gate
from app.core.kernels.windows import NOTHING, half_cells
from app.core.normals.rules import HALO

MOST = (2 * HALO + 1) ** 2
COARSE = 8
"""Cells to either side from which on a window is thinned."""
LEAST_SPREAD = 0.5
"""Of a window's rows or columns, in cells² summed over all: below it there is one line only."""


NO_PLANE = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Room(NamedTuple):
    """Cells of one window, side by side."""

    v: Any  # 1 / range
    i: Any  # rows from the centre
    j: Any  # columns
    known: Any  # 1 within the gate, else 0
    shape: Any  # (2,) half-width of the window that `i` and `j` are filled for


@njit(**INNER)
def make_room():  # type: ignore[no-untyped-def]
    """Memory for the largest window."""
    return Room(
        np.empty(MOST), np.empty(MOST), np.empty(MOST), np.empty(MOST), np.zeros(2, np.int64)
    )


@njit(**INNER, fastmath=SAFE, forceinline=True)
def gather(w, i, j, high, wide, low, top, cone, room):  # type: ignore[no-untyped-def]
    """Copy the cells of a window; how many there are, and how many count.

    Those do that differ by no more than two limits, which grow with the distance in cells where
    `cone` is 1, and that are no hole, which is 0 precisely.
    """
    v, di, dj, known, shape = room.v, room.i, room.j, room.known, room.shape
    own = w[i, j]
    # Every other row and column of a large window tell as much of what does not belong.
    down, side = 1 + high // COARSE, 1 + wide // COARSE
    up, left = high // down, wide // side
    width = 2 * left + 1
    n = (2 * up + 1) * width
    if shape[0] != high or shape[1] != wide:
        shape[0], shape[1] = high, wide
        for line in range(2 * up + 1):  # no division: it costs more than the fit
            for k in range(width):
                di[line * width + k], dj[line * width + k] = (line - up) * down, (k - left) * side
    for line in range(2 * up + 1):
        for k in range(width):
            v[line * width + k] = w[i + (line - up) * down, j + (k - left) * side]
    inside = 0.0
    for k in range(n):
        far = 1.0 + cone * (max(abs(di[k]), abs(dj[k])) - 1.0)
        off = v[k] - own
        known[k] = 1.0 if (off > low * far) & (off < top * far) & (v[k] != 0.0) else 0.0
        inside += known[k]
    return n, inside


@njit(**INNER, fastmath=SAFE, forceinline=True)
def fit_weighted(room, n, c, a, b, over):  # type: ignore[no-untyped-def]
    """Plane through cells weighted by their residual from the plane c + a i + b j.

    `over` is one over the residual from which on a cell counts for nothing; 0 weighs all alike.
    Gives weight, value at the centre, slopes, squared residual, inverse of the moments
    (rows, columns, both), and the cells' middle; a weight of 0 where they define no plane.
    """
    v, di, dj, known = room.v, room.i, room.j, room.known
    s = si = sj = sv = sii = sij = sjj = siv = sjv = svv = 0.0
    for k in range(n):
        x, y, z = di[k], dj[k], v[k]
        t = (z - c - a * x - b * y) * over
        t = 1.0 - t * t
        t = max(t, 0.0)
        g = t * t * known[k]
        gx, gy, gz = g * x, g * y, g * z
        s += g
        si += gx
        sj += gy
        sv += gz
        sii += gx * x
        sij += gx * y
        sjj += gy * y
        siv += gx * z
        sjv += gy * z
        svv += gz * z
    if s <= 3.0:
        return NO_PLANE
    mi, mj, mv = si / s, sj / s, sv / s
    ii, ij, jj = sii - si * mi, sij - si * mj, sjj - sj * mj
    iv, jv, vv = siv - si * mv, sjv - sj * mv, svv - sv * mv
    det = ii * jj - ij * ij
    if not (det > 1e-3 * ii * jj and ii > LEAST_SPREAD and jj > LEAST_SPREAD):
        return NO_PLANE
    a, b = (iv * jj - jv * ij) / det, (jv * ii - iv * ij) / det
    square = max(vv - a * iv - b * jv, 0.0) / max(s - 3.0, 1.0)
    return s, mv - a * mi - b * mj, a, b, square, jj / det, ii / det, -ij / det, mi, mj


@njit(**INNER, forceinline=True)
def fit_careful(tile, base, i, j, down, side, rules, width, room):  # type: ignore[no-untyped-def]
    """Fit over the cells within a gate; with weights where more than noise is in them."""
    own = tile.w[i, j]
    w = own + base
    r = 1.0 / w
    sigma = rules.noise * w * w
    reach = gate(r, max(abs(down), abs(side)), rules.slope, rules.jump * rules.noise)
    low, top = 1.0 / (r + reach) - w, 1.0 / max(r - reach, 1e-3 * r) - w
    high, wide = half_cells(width, w, down, side)
    n, inside = gather(tile.w, i, j, high, wide, low, top, 0.0, room)
    if inside < rules.least:
        n, inside = gather(tile.w, i, j, high, wide, low, top, 1.0, room)
    if inside < rules.least:
        return NOTHING
    found = fit_weighted(room, n, own, 0.0, 0.0, 0.0)
    if not found[0] > 0.0:
        return NOTHING
    # What lies off the surface is in this variance, and so in σ, but not in the plane.
    square = found[4]
    if square > rules.calm * sigma * sigma:
        found = reweigh(room, n, found, rules, sigma)
    return (
        int(found[0] + 0.5), high, wide, found[8], found[9], found[1], found[2], found[3],
        square * found[5], square * found[6], square * found[7], found[4],
    )  # fmt: skip


@njit(**INNER, forceinline=True)
def reweigh(room, n, found, rules, sigma):  # type: ignore[no-untyped-def]
    """Fit again and again with weights from the residuals before, until they stay."""
    for _ in range(rules.passes):
        cut = max(rules.cut * np.sqrt(found[4]), rules.least_cut * sigma)
        if cut <= 0.0:
            break
        again = fit_weighted(room, n, found[1], found[2], found[3], 1.0 / cut)
        if again[0] == 0.0:
            break
        settled = abs(again[4] - found[4]) < 0.02 * found[4]
        found = again
        if settled:
            break
    return found
