"""What the beams around a point say about it: how far off their ranges are, and how straight
the lines through them run.

Points are taken in batches, one lane each, so that every step is one short loop over lanes
which the compiler turns into vector instructions.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.kernels.ghost_image import MARGIN
from app.core.kernels.small_network import LANES, weigh_lanes

HALF = 3
"""Cells on either side that are looked at."""
BINS = 10
"""Classes of range difference: below 0.5, 1, 2, … 128 mm, and beyond."""
FINEST = 0.0005
LINES, STARS = 12, 8
KEPT_LINES = (0, 1, 2, 3, 5, 7, 10)
KEPT_STARS = (0, 1, 2, 4, 6)
NARROWEST, WIDEST = 0.1, 20.0
"""Beam diameters over the step; beyond them nothing was learned."""
LARGEST = 5.3
"""Logarithm of a bend that is no longer one: 0.1 m."""
COUNTED = 4 * BINS + 2
COUNT = COUNTED + len(KEPT_LINES) + len(KEPT_STARS) + 3
DOWNS = (0, 1, 1, 1, 0, 2, 2, 2, 1, 2, 1, 2)
ACROSSES = (1, 0, 1, -1, 2, 0, 2, -2, 2, 1, -2, -1)
STAR_DOWNS = (-1, -1, -1, 0, 0, 1, 1, 1)
STAR_ACROSSES = (-1, 0, 1, -1, 1, -1, 0, 1)
SIDE = 2 * HALF + 1
CENTRE = SIDE * HALF + HALF
NEAR = (16, 17, 18, 23, 25, 30, 31, 32)
"""Cells of the window beside its centre."""
BITS = 6
"""Of a count up to 40; the counts of ten classes share 64 bits."""
MASK = 2**BITS - 1


@njit(cache=True, nogil=True, forceinline=True)
def _difference(image, y, x, own):  # type: ignore[no-untyped-def]
    """Range of the cell less the own, of the layer nearest to it; NaN without one."""
    best = image[0, y, x] - own
    for layer in range(1, image.shape[0]):
        other = image[layer, y, x] - own
        if not abs(best) <= abs(other) and other == other:
            best = other
    return best


@njit(cache=True, nogil=True, forceinline=True)
def _is_level(image, y, x, own, jump):  # type: ignore[no-untyped-def]
    """Whether no beam beside is off by more than a steep surface, and half of them are there.

    The sky beside a point is no second surface.
    """
    missing = 0
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            off = abs(_difference(image, y + dy, x + dx, own))
            if off > jump:
                return False
            missing += off != off
    return missing <= 4


@njit(cache=True, nogil=True)
def pick_doubtful(  # type: ignore[no-untyped-def]
    points, first, last, own, row, column, image, down, across, jump, steepest, doubtful
):
    """Write the places, in the list of points, of those that a beam beside is off from.

    Gives their number. Points without a range are left out.
    """
    count = 0
    for k in range(first, last):
        i = points[k]
        if not 0.0 < own[i] < math.inf:
            continue
        steep = steepest * own[i] * math.sqrt(down[column[i]] * across[row[i]])
        if not _is_level(image, row[i] + MARGIN, column[i] + MARGIN, own[i], jump + steep):
            doubtful[count] = k
            count += 1
    return count


@njit(cache=True, nogil=True)
def gather_evidence(  # type: ignore[no-untyped-def]
    places, points, own, row, column, image, down, across, radius, spread, noise, evidence
):
    """Write the evidence on each of the points at these places, (places, COUNT).

    Shares of the 8 beams around and of the 40 beyond them by range difference, farther ones
    and nearer ones apart, and of those missing; bends of lines through the point and away from
    it, sorted; beam diameter over the step, step and noise.
    """
    window, found = np.zeros((SIDE * SIDE, LANES), np.float32), _make_room()
    far, near, bends = _make_counters(), _make_counters(), np.empty((LINES, LANES), np.float32)
    for start in range(0, places.size, LANES):
        size = min(LANES, places.size - start)
        _look_around(
            places[start : start + size], points, own, row, column, image, down, across, radius,
            spread, noise, window, found,
        )  # fmt: skip
        _describe(window, far, near, bends, found)
        for p in range(size):
            for f in range(COUNT):
                evidence[start + p, f] = found[f, p]


@njit(cache=True, nogil=True)
def glance_at(  # type: ignore[no-untyped-def]
    places, points, own, row, column, image, down, across, radius, spread, noise,
    w1, b1, w2, b2, w3, b3, score,
):  # fmt: skip
    """Write what a network of two layers says of the evidence on each of the points.

    The same as `gather_evidence` and three products of matrices, without the room for them.
    """
    window, found = np.zeros((SIDE * SIDE, LANES), np.float32), _make_room()
    far, near, bends = _make_counters(), _make_counters(), np.empty((LINES, LANES), np.float32)
    one, two = np.empty((b1.size, LANES), np.float32), np.empty((b2.size, LANES), np.float32)
    last = np.empty((1, LANES), np.float32)
    for start in range(0, places.size, LANES):
        size = min(LANES, places.size - start)
        _look_around(
            places[start : start + size], points, own, row, column, image, down, across, radius,
            spread, noise, window, found,
        )  # fmt: skip
        _describe(window, far, near, bends, found)
        weigh_lanes(found, w1, b1, w2, b2, w3, b3, one, two, last, score, start, size)


@njit(cache=True, nogil=True)
def _make_room():  # type: ignore[no-untyped-def]
    return np.zeros((COUNT, LANES), np.float32)


@njit(cache=True, nogil=True)
def _make_counters():  # type: ignore[no-untyped-def]
    return np.empty((2, LANES), np.uint64)


@njit(cache=True, nogil=True)
def _look_around(  # type: ignore[no-untyped-def]
    places, points, own, row, column, image, down, across, radius, spread, noise, window, found
):
    """Fill a lane with the window and the beam of each of the points at these places."""
    for p in range(places.size):
        i = points[places[p]]
        step = own[i] * math.sqrt(down[column[i]] * across[row[i]])
        _look(image, row[i] + MARGIN, column[i] + MARGIN, own[i], window, p)
        _describe_beam(step, 2.0 * (radius + own[i] * spread) / step, noise, found, p)


@njit(cache=True, nogil=True, forceinline=True)
def _look(image, y, x, own, window, p):  # type: ignore[no-untyped-def]
    """Range differences of the beams of the window, row by row."""
    k = 0
    for dy in range(-HALF, HALF + 1):
        for dx in range(-HALF, HALF + 1):
            window[k, p] = _difference(image, y + dy, x + dx, own)
            k += 1


@njit(cache=True, nogil=True, forceinline=True)
def _describe_beam(step, width, noise, found, p):  # type: ignore[no-untyped-def]
    found[COUNT - 3, p] = math.log(min(max(width, NARROWEST), WIDEST))
    found[COUNT - 2, p] = math.log(step / FINEST)
    found[COUNT - 1, p] = math.log1p(noise / FINEST)


@njit(cache=True, nogil=True, forceinline=True)
def _describe(window, far, near, bends, found):  # type: ignore[no-untyped-def]
    _share_out(window, far, near, found)
    for line in range(LINES):
        place = DOWNS[line] * SIDE + ACROSSES[line]
        for p in range(LANES):
            bend = abs(window[CENTRE + place, p] + window[CENTRE - place, p])
            bends[line, p] = bend if bend == bend else math.inf
    _sort(bends, LINES)
    for n in range(len(KEPT_LINES)):
        _shrink(bends, KEPT_LINES[n], found, COUNTED + n)
    for star in range(STARS):
        place = STAR_DOWNS[star] * SIDE + STAR_ACROSSES[star]
        for p in range(LANES):
            bend = abs(np.float32(2.0) * window[CENTRE + place, p] - window[CENTRE + 2 * place, p])
            bends[star, p] = bend if bend == bend else math.inf
    _sort(bends, STARS)
    for n in range(len(KEPT_STARS)):
        _shrink(bends, KEPT_STARS[n], found, COUNTED + len(KEPT_LINES) + n)


@njit(cache=True, nogil=True)
def _share_out(window, far, near, found):  # type: ignore[no-untyped-def]
    """Shares of both rings by class."""
    for ring in range(2):
        for p in range(LANES):
            far[ring, p], near[ring, p] = 0, 0
    for k in range(SIDE * SIDE):
        if k != CENTRE:
            _count(window, k, 0 if k in NEAR else 1, far, near)
    for ring in range(2):
        _spread_out(far, near, ring, 0.125 if ring == 0 else 0.025, found)


@njit(cache=True, nogil=True, forceinline=True)
def _count(window, k, ring, far, near):  # type: ignore[no-untyped-def]
    """Add the cell to the class of its difference: how often the finest doubles to its size."""
    for p in range(LANES):
        d = window[k, p]
        bits = np.float32(abs(d) * np.float32(1.0 / FINEST)).view(np.int32)
        # The exponent of a float is the whole part of its logarithm.
        doubled = (bits >> 23) - 126
        place = 0 if doubled < 0 else (doubled if doubled < BINS else BINS - 1)
        one = np.uint64(d == d) << np.uint64(BITS * place)
        nearer = np.uint64(d < np.float32(0.0))
        far[ring, p] += one * (np.uint64(1) - nearer)
        near[ring, p] += one * nearer


@njit(cache=True, nogil=True, forceinline=True)
def _spread_out(far, near, ring, share, found):  # type: ignore[no-untyped-def]
    """Counts that share 64 bits as shares of their own."""
    first, share = 2 * BINS * ring, np.float32(share)
    for p in range(LANES):
        found[4 * BINS + ring, p] = np.float32(1.0)
    for c in range(BINS):
        move = np.uint64(BITS * c)
        for p in range(LANES):
            farther = share * np.float32(np.int32((far[ring, p] >> move) & np.uint64(MASK)))
            nearer = share * np.float32(np.int32((near[ring, p] >> move) & np.uint64(MASK)))
            found[first + c, p], found[first + BINS + c, p] = farther, nearer
            found[4 * BINS + ring, p] -= farther + nearer


@njit(cache=True, nogil=True)
def _sort(values, size):  # type: ignore[no-untyped-def]
    """Sort each lane (Batcher's odd-even merge sort: the same exchanges whatever the values)."""
    block = 1
    while block < size:
        apart = block
        while apart >= 1:
            for first in range(apart % block, size - apart, 2 * apart):
                for n in range(first, min(first + apart, size - apart)):
                    if n // (2 * block) == (n + apart) // (2 * block):
                        for p in range(LANES):
                            low, high = values[n, p], values[n + apart, p]
                            values[n, p] = low if low < high else high
                            values[n + apart, p] = high if low < high else low
            apart //= 2
        block *= 2


@njit(cache=True, nogil=True, forceinline=True)
def _shrink(bends, n, found, f):  # type: ignore[no-untyped-def]
    """Logarithm of one more than the bend over the finest, without the largest.

    By exponent and a series of the mantissa, to 1e-6: the library's would be taken lane by lane.
    """
    for p in range(LANES):
        x = min(bends[n, p] * np.float32(1.0 / FINEST) + np.float32(1.0), np.float32(1e6))
        bits = np.float32(x).view(np.int32)
        exponent = (bits >> 23) - 127
        mantissa = np.int32((bits & 0x7FFFFF) | 0x3F800000).view(np.float32)
        s = (mantissa - np.float32(1.4142135)) / (mantissa + np.float32(1.4142135))
        q = s * s
        series = (
            np.float32(2.0)
            * s
            * (
                np.float32(1.0)
                + q * (np.float32(1 / 3) + q * (np.float32(0.2) + q * np.float32(1 / 7)))
            )
        )
        logarithm = series + (np.float32(exponent) + np.float32(0.5)) * np.float32(0.6931472)
        found[f, p] = min(max(logarithm, np.float32(0.0)), np.float32(LARGEST))
