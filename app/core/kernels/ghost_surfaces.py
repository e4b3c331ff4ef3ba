"""The surfaces along a beam, carried on from the beams around that hit one surface only.

Every plane of space is linear in the direction when it is told by its inverse range, so that it
can be carried on over several beams.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.kernels.ghost_evidence import MARGIN

WIDEST = MARGIN
MOST = (2 * WIDEST + 1) ** 2
MEMBERS = 4
"""Beams that make a surface."""
SURFACES = 3
PER_SURFACE = 9
RANGE, SCATTER, MASS, SIZE, LIGHT, DOWN, ACROSS, NEAR_DOWN, NEAR_ACROSS = range(PER_SURFACE)
"""Of each surface, nearest in range first: range at the beam and scatter about the plane (metres),
weight of its beams by a Gaussian of the footprint's size, their number, mean intensity, slopes of
the range down and across (metres per cell), and where its nearest beam is (cells)."""
DEEPEST = 4
STEEPEST = 4.0


@njit(cache=True, nogil=True)
def measure_depth(image, mixed, depth):  # type: ignore[no-untyped-def]
    """Cells from each clean cell to the nearest mixed one, up to `DEEPEST`; 0 mixed, or none.

    A beam farther from the border holds less of the other surface.
    """
    rows, columns = depth.shape
    for y in range(rows):
        for x in range(columns):
            depth[y, x] = DEEPEST if image[y, x] == image[y, x] and not mixed[y, x] else 0
    for y in range(1, rows - 1):
        for x in range(1, columns - 1):
            _lower(mixed, depth, y, x, -1)
    for y in range(rows - 2, 0, -1):
        for x in range(columns - 2, 0, -1):
            _lower(mixed, depth, y, x, 1)


@njit(cache=True, nogil=True, forceinline=True)
def _lower(mixed, depth, y, x, way):  # type: ignore[no-untyped-def]
    """One more than the least of the neighbours that a pass has been at; the sky counts not."""
    least = depth[y, x]
    if least == 0:
        return
    for k in range(4):
        dy = 0 if k == 3 else way
        dx = way if k == 3 else k - 1
        other = depth[y + dy, x + dx]
        if other + 1 < least and (other > 0 or mixed[y + dy, x + dx]):
            least = other + 1
    depth[y, x] = least


@njit(cache=True, nogil=True)
def find_surfaces(  # type: ignore[no-untyped-def]
    points, own, row, column, image, depth, light, down, across, radius, spread, gap, found
):
    """Write the surfaces along the beam of each point, (points, SURFACES, PER_SURFACE).

    `found` is left as it is where there is none. The point itself takes no part.
    """
    away, weight, bright = np.empty(MOST), np.empty(MOST), np.empty(MOST)
    dy, dx = np.empty(MOST, np.int64), np.empty(MOST, np.int64)
    fall, trust = np.empty(WIDEST + 1), 4.0 ** np.arange(DEEPEST + 1)
    for k in range(points.size):
        i = points[k]
        if not 0.0 < own[i] < math.inf:
            continue
        step = own[i] * math.sqrt(down[column[i]] * across[row[i]])
        blur = (radius + own[i] * spread) / step
        half = min(max(math.ceil(2.0 * blur) + 3, 4), WIDEST)
        y, x = row[i] + MARGIN, column[i] + MARGIN
        for n in range(half + 1):
            fall[n] = math.exp(-0.5 * n * n / max(blur * blur, 1.0))
        size = _collect(
            image, depth, light, y, x, half, own[i], fall, trust, away, weight, bright, dy, dx
        )
        for s in range(SURFACES):
            size = _take(
                away, weight, bright, dy, dx, size, own[i], gap + STEEPEST * step, found, k, s
            )
            if size == 0:
                break


@njit(cache=True, nogil=True, forceinline=True)
def _collect(  # type: ignore[no-untyped-def]
    image, depth, light, y, x, half, own, fall, trust, away, weight, bright, downs, acrosses
):
    """Clean beams of the window: range off the own, weight, light and place; their number."""
    size = 0
    for dy in range(-half, half + 1):
        for dx in range(-half, half + 1):
            deep = depth[y + dy, x + dx]
            if deep == 0 or (dy == 0 and dx == 0):
                continue
            away[size] = image[y + dy, x + dx] - own
            weight[size] = (fall[abs(dy)] * fall[abs(dx)] + 0.02) * trust[deep]
            bright[size] = light[y + dy, x + dx]
            downs[size], acrosses[size] = dy, dx
            size += 1
    return size


@njit(cache=True, nogil=True, forceinline=True)
def _take(  # type: ignore[no-untyped-def]
    away, weight, bright, dy, dx, size, own, gap, found, k, s
):
    """Fit the beams that no gap parts from the one nearest in range; the others move up.

    Gives the number of the others; too few beams are no surface and are passed over.
    """
    while size > 0:
        low, high = _grow(away, size, gap)
        count = 0
        for n in range(size):
            count += low <= away[n] <= high
        if count >= MEMBERS:
            _fit(away, weight, bright, dy, dx, size, own, low, high, found, k, s)
        left = 0
        for n in range(size):
            if not low <= away[n] <= high:
                away[left], weight[left], bright[left] = away[n], weight[n], bright[n]
                dy[left], dx[left] = dy[n], dx[n]
                left += 1
        size = left
        if count >= MEMBERS:
            return size
    return 0


@njit(cache=True, nogil=True, forceinline=True)
def _grow(away, size, gap):  # type: ignore[no-untyped-def]
    """Lowest and highest of the ranges that no gap parts from the one nearest to 0."""
    low = away[0]
    for n in range(1, size):
        if abs(away[n]) < abs(low):
            low = away[n]
    high, grown = low, True
    while grown:
        grown = False
        for n in range(size):
            if low - gap <= away[n] < low:
                low, grown = away[n], True
            elif high < away[n] <= high + gap:
                high, grown = away[n], True
    return low, high


@njit(cache=True, nogil=True)
def _fit(  # type: ignore[no-untyped-def]
    away, weight, bright, dy, dx, size, own, low, high, found, k, s
):
    """Plane of the inverse range of the beams between two ranges, at the own beam."""
    n = a = b = v = aa = ab = bb = av = bv = vv = shine = 0.0
    count, level, nearest = 0, 1.0 / (own + 0.5 * (low + high)), math.inf
    for m in range(size):
        if not low <= away[m] <= high:
            continue
        w, dv, da, db = weight[m], 1.0 / (own + away[m]) - level, dy[m], dx[m]
        n += w
        a += w * da
        b += w * db
        v += w * dv
        aa += w * da * da
        ab += w * da * db
        bb += w * db * db
        av += w * da * dv
        bv += w * db * dv
        vv += w * dv * dv
        shine += w * bright[m]
        count += 1
        if da * da + db * db < nearest:
            nearest = da * da + db * db
            found[k, s, NEAR_DOWN], found[k, s, NEAR_ACROSS] = da, db
    # A little stiffness: beams in one line do not tell the slope across it.
    aa, ab, bb = aa - a * a / n + 0.02 * n, ab - a * b / n, bb - b * b / n + 0.02 * n
    av, bv, vv = av - a * v / n, bv - b * v / n, vv - v * v / n
    det = aa * bb - ab * ab
    up, side = (av * bb - bv * ab) / det, (bv * aa - av * ab) / det
    inverse = level + (v - up * a - side * b) / n
    rest = max(vv - up * av - side * bv, 0.0) / n
    spare = 0.5 * (high - low) + 0.002
    lowest, highest = own + low - spare, own + high + spare
    fitted = min(max(1.0 / inverse, lowest), highest) if inverse > 0.0 else highest
    square = fitted * fitted
    found[k, s, RANGE], found[k, s, SCATTER] = fitted, math.sqrt(rest) * square
    found[k, s, MASS], found[k, s, SIZE], found[k, s, LIGHT] = n, count, shine / n
    found[k, s, DOWN], found[k, s, ACROSS] = -up * square, -side * square
