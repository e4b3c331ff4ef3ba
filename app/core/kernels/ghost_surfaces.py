"""The surfaces along a beam, carried on from the beams around that hit one surface only.

Every plane of space is linear in the direction when it is told by its inverse range, so that it
can be carried on over several beams.

The beams of a window lie in lists of a whole number of vectors; each step is one loop over them
without a branch, which the compiler turns into vector instructions. Range differences are whole
micrometres there: of integers the least of eight is one instruction.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.kernels.ghost_image import MARGIN, MOST_LAYERS

WIDEST = MARGIN
LANES = 32
MOST = MOST_LAYERS * (((2 * WIDEST + 1) ** 2 + LANES - 1) // LANES * LANES)
NOWHERE = 2**30
"""Micrometres off, of a beam that takes no part."""
PER_METRE = np.float32(1e6)

MEMBERS = 4
"""Beams that make a surface."""
SURFACES = 3
PER_SURFACE = 10
RANGE, SCATTER, LIGHT, SLOPE, AWAY, MASS, SIZE, NEAR_LAYER, NEAR_DOWN, NEAR_ACROSS = range(10)
"""Of each surface, nearest in range first: range at the beam and scatter about the plane (metres),
mean intensity, slope over the breadth at the range of the point, cells to its nearest beam, weight
of its beams by a Gaussian of the footprint's size, their number, and where the nearest is (layer,
and cells)."""
DEEPEST, EMPTY = 4, np.uint8(255)
STEEPEST = 4.0


@njit(cache=True, nogil=True)
def measure_depth(image, mixed, depth):  # type: ignore[no-untyped-def]
    """Cells from each clean cell to the nearest mixed one, up to `DEEPEST`; 0 mixed, or none.

    Steps lead over clean cells: the sky counts not. A beam farther from the border holds less
    of the other surface.
    """
    rows, columns = depth.shape
    for y in range(rows):
        for x in range(columns):
            clean = np.uint8(DEEPEST) if image[y, x] == image[y, x] else EMPTY
            depth[y, x] = np.uint8(0) if mixed[y, x] else clean
    across = np.full(depth.shape, EMPTY)
    for _ in range(DEEPEST - 1):
        for y in range(rows):
            for x in range(1, columns - 1):
                beside = min(depth[y, x - 1], depth[y, x + 1])
                across[y, x] = min(beside, depth[y, x])
        for y in range(1, rows - 1):
            for x in range(1, columns - 1):
                least = min(min(across[y - 1, x], across[y + 1, x]), across[y, x])
                # Over the sky it wraps round to 0, and is not used.
                least = np.uint8(least + np.uint8(1))
                own = depth[y, x]
                depth[y, x] = own if own == EMPTY else min(own, least)
    for y in range(rows):
        for x in range(columns):
            depth[y, x] = np.uint8(0) if depth[y, x] == EMPTY else depth[y, x]


@njit(cache=True, nogil=True)
def find_surfaces(  # type: ignore[no-untyped-def]
    points, own, row, column, image, inverse, trust, light, down, across, radius, spread, gap, found
):
    """Write the surfaces along the beam of each point, (points, SURFACES, PER_SURFACE).

    Where there is none, NaN and no beams. The beam itself takes no part. `image`, `inverse`
    (one over its ranges), `trust` (0: takes no part) and `light` are (layers, rows, columns), with
    `MARGIN` around.
    """
    away, near = np.empty(MOST, np.int32), np.empty(MOST, np.int32)
    weight, bright = np.empty(MOST, np.float32), np.empty(MOST, np.float32)
    upright = np.empty(MOST, np.float32)
    dy, dx = np.zeros(MOST, np.float32), np.zeros(MOST, np.float32)
    fall, aside = np.empty(WIDEST + 1), np.empty(2 * WIDEST + 1, np.float32)
    flat, inverses, trusts, lights = image.ravel(), inverse.ravel(), trust.ravel(), light.ravel()
    layers, rows, columns = image.shape
    known, block = -1, 0
    for k in range(points.size):
        i = points[k]
        for s in range(SURFACES):
            for f in range(PER_SURFACE):
                found[k, s, f] = math.nan if f <= AWAY else 0.0
        if not 0.0 < own[i] < math.inf:
            continue
        height, width = own[i] * down[column[i]], own[i] * across[row[i]]
        step = math.sqrt(height * width)
        blur = (radius + own[i] * spread) / step
        half = min(max(math.ceil(2.0 * blur) + 3, 4), WIDEST)
        if half != known:
            known, block = half, _lay_window(half, layers, dy, dx, near)
        _lay_fall(math.exp(-0.5 / max(blur * blur, 1.0)), half, fall, aside)
        first = (row[i] + MARGIN - half) * columns + column[i] + MARGIN - half
        for layer in range(layers):
            _collect(
                flat, inverses, trusts, lights, first + layer * rows * columns, columns, half,
                np.float32(own[i]), fall, aside, away, weight, bright, upright,
                layer * block, block,
            )  # fmt: skip
        size = layers * block
        apart = np.int32((gap + STEEPEST * step) * PER_METRE)
        low = high = np.int32(NOWHERE)
        for s in range(SURFACES):
            low, high = _part(away, size, apart, low, high)
            if low == NOWHERE:
                break
            up, side, nearest = _fit(
                away, weight, bright, upright, dy, dx, near, size, own[i], low, high, found[k, s]
            )
            found[k, s, SLOPE] = math.hypot(up / height, side / width)
            found[k, s, AWAY] = math.hypot(dy[nearest], dx[nearest])
            found[k, s, NEAR_LAYER] = nearest // block
            found[k, s, NEAR_DOWN], found[k, s, NEAR_ACROSS] = dy[nearest], dx[nearest]


@njit(cache=True, nogil=True, forceinline=True)
def _lay_fall(base, half, fall, aside):  # type: ignore[no-untyped-def]
    """Gaussian of the distance in cells, its value one cell off given; also over a whole row."""
    value, ratio = 1.0, base
    for n in range(half + 1):
        fall[n] = aside[half - n] = aside[half + n] = value
        value, ratio = value * ratio, ratio * base * base


@njit(cache=True, nogil=True)
def _lay_window(half, layers, dy, dx, near):  # type: ignore[no-untyped-def]
    """Places of the cells of a window and their order by distance; room for one layer of them."""
    side = 2 * half + 1
    block = (side * side + LANES - 1) // LANES * LANES
    for layer in range(layers):
        for n in range(side * side):
            m = layer * block + n
            dy[m], dx[m] = n // side - half, n % side - half
            near[m] = np.int32(dy[m] * dy[m] + dx[m] * dx[m]) * MOST + m
    return block


@njit(cache=True, nogil=True, forceinline=True)
def _collect(  # type: ignore[no-untyped-def]
    image, inverse, trust, light, first, columns, half, own, fall, aside,
    away, weight, bright, upright, place, block,
):  # fmt: skip
    """Clean beams of the window: range off the own, weight, light and inverse range."""
    side = 2 * half + 1
    for y in range(side):
        # Unsigned: a signed place might count from the end, which no vector of them can.
        to, start = np.uint64(place + y * side), np.uint64(first + y * columns)
        down = np.float32(fall[abs(y - half)])
        for x in range(side):
            m, at = to + np.uint64(x), start + np.uint64(x)
            off = np.int32((image[at] - own) * PER_METRE)
            away[m] = off if trust[at] > np.float32(0.0) else np.int32(NOWHERE)
            weight[m] = (down * aside[x] + np.float32(0.02)) * trust[at]
        for x in range(side):
            m, at = to + np.uint64(x), start + np.uint64(x)
            bright[m], upright[m] = light[at], inverse[at]
    away[place + half * side + half] = NOWHERE
    for rest in range(side * side, block):
        away[place + rest] = NOWHERE


@njit(cache=True, nogil=True, forceinline=True)
def _part(away, size, gap, low, high):  # type: ignore[no-untyped-def]
    """Lowest and highest of the beams that no gap parts from the one nearest in range.

    Beams from `low` to `high` are taken out first. Too few beams are no surface and are passed
    over; `NOWHERE` when none are left.
    """
    while True:
        beyond, before = np.int32(NOWHERE), np.int32(-NOWHERE)
        for n in range(size):
            other = away[n]
            other = np.int32(NOWHERE) if (other >= low) & (other <= high) else other
            away[n] = other
            beyond = min(beyond, other if other >= np.int32(0) else np.int32(NOWHERE))
            before = max(before, other if other < np.int32(0) else np.int32(-NOWHERE))
        if beyond == NOWHERE and before == -NOWHERE:
            return np.int32(NOWHERE), np.int32(NOWHERE)
        low = high = beyond if beyond <= -before else before
        count = np.int32(0)
        while True:
            lower, higher, count = low, high, np.int32(0)
            least, most = np.int32(low - gap), np.int32(high + gap)
            for n in range(size):
                other = away[n]
                inside = (other >= least) & (other <= most)
                lower = min(lower, other if inside else low)
                higher = max(higher, other if inside else high)
                count = np.int32(count + np.int32(inside))
            if lower == low and higher == high:
                break
            low, high = lower, higher
        if count >= MEMBERS:
            return low, high


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _fit(  # type: ignore[no-untyped-def]
    away, weight, bright, upright, dy, dx, near, size, own, low, high, found
):
    """Plane of the inverse range of the beams between two ranges, at the own beam.

    Gives its slopes (metres per cell) and the place of the beam of theirs nearest to the own.
    """
    lowest, highest = low / PER_METRE, high / PER_METRE
    level = np.float32(1.0 / (own + 0.5 * (lowest + highest)))
    none = np.float32(0.0)
    n = a = b = v = aa = ab = bb = av = bv = vv = shine = none
    count, nearest = np.int32(0), np.int32(NOWHERE)
    for m in range(size):
        inside = (away[m] >= low) & (away[m] <= high)
        w = weight[m] if inside else none
        dv = upright[m] - level if inside else none
        light = bright[m] if inside else none
        da, db = dy[m], dx[m]
        wa, wb, wv = w * da, w * db, w * dv
        n += w
        a += wa
        b += wb
        v += wv
        aa += wa * da
        ab += wa * db
        bb += wb * db
        av += wa * dv
        bv += wb * dv
        vv += wv * dv
        shine += w * light
        count = np.int32(count + np.int32(inside))
        nearest = min(nearest, near[m] if inside else np.int32(NOWHERE))
    mass = np.float64(n)
    y, x, mean = a / mass, b / mass, v / mass
    # A little stiffness: beams in one line do not tell the slope across it.
    yy, xy, xx = aa / mass - y * y + 0.02, ab / mass - y * x, bb / mass - x * x + 0.02
    yv, xv, spread = av / mass - y * mean, bv / mass - x * mean, vv / mass - mean * mean
    det = yy * xx - xy * xy
    up, side = (yv * xx - xv * xy) / det, (xv * yy - yv * xy) / det
    inverse = level + mean - up * y - side * x
    rest = max(0.0, spread - up * yv - side * xv)
    spare = 0.5 * (highest - lowest) + 0.002
    lowest, highest = own + lowest - spare, own + highest + spare
    fitted = min(max(1.0 / inverse, lowest), highest) if inverse > 0.0 else highest
    square = fitted * fitted
    found[RANGE], found[SCATTER], found[LIGHT] = fitted, math.sqrt(rest) * square, shine / mass
    found[MASS], found[SIZE] = mass, count
    return -up * square, -side * square, nearest % MOST
