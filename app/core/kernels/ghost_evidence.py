"""What the beams around a point say about it: how far off their ranges are, and how straight
the lines through them run.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

MARGIN = 8
"""Cells without a beam around the image, so that no window leaves it."""
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


@njit(cache=True, nogil=True)
def lay_out(own, row, column, layer, image):  # type: ignore[no-untyped-def]
    """Ranges in a padded image (layers, rows, columns); `layer` tells points of a cell apart."""
    for i in range(own.size):
        if layer[i] < image.shape[0] and 0.0 < own[i] < math.inf:
            image[layer[i], row[i] + MARGIN, column[i] + MARGIN] = own[i]


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
def _classify(d):  # type: ignore[no-untyped-def]
    """Class of a range difference: how often its size is twice the finest, nearer ones apart."""
    bits = np.float32(abs(d) * (1.0 / FINEST)).view(np.int32)
    # The exponent of a float is the whole part of its logarithm.
    k: int = min(max(int(bits >> 23) - 126, 0), BINS - 1)
    return k + BINS if d < 0.0 else k


@njit(cache=True, nogil=True, forceinline=True)
def _keep(values, size, value):  # type: ignore[no-untyped-def]
    """Put a value into its place of a sorted list; what is missing comes last."""
    value = value if value == value else math.inf
    k = size
    while k > 0 and values[k - 1] > value:
        values[k] = values[k - 1]
        k -= 1
    values[k] = value


@njit(cache=True, nogil=True, forceinline=True)
def _shrink(bend):  # type: ignore[no-untyped-def]
    """Logarithm of a bend, without the largest."""
    return min(math.log1p(bend / FINEST), LARGEST)


@njit(cache=True, nogil=True, forceinline=True)
def _is_level(image, y, x, own, jump, slope):  # type: ignore[no-untyped-def]
    """Whether no beam of the window is off by more than a steep surface, and half are there.

    The sky beside a point is no second surface.
    """
    missing = 0
    for dy in range(-HALF, HALF + 1):
        for dx in range(-HALF, HALF + 1):
            off = abs(_difference(image, y + dy, x + dx, own))
            if off > jump + slope * max(abs(dy), abs(dx)):
                return False
            missing += off != off
    return 2 * missing <= SIDE * SIDE


@njit(cache=True, nogil=True)
def pick_doubtful(  # type: ignore[no-untyped-def]
    points, first, last, own, row, column, image, down, across, jump, steepest, doubtful
):
    """Write the places, in the list of points, of those that something around is off from.

    Gives their number. Points without a range are left out.
    """
    count = 0
    for k in range(first, last):
        i = points[k]
        if not 0.0 < own[i] < math.inf:
            continue
        slope = steepest * own[i] * math.sqrt(down[column[i]] * across[row[i]])
        if not _is_level(image, row[i] + MARGIN, column[i] + MARGIN, own[i], jump, slope):
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
    window, bends = np.empty(SIDE * SIDE, np.float32), np.empty(LINES, np.float32)
    row_of = np.empty(COUNT, np.float32)
    for k in range(places.size):
        i = points[places[k]]
        step = own[i] * math.sqrt(down[column[i]] * across[row[i]])
        width = 2.0 * (radius + own[i] * spread) / step
        _look(image, row[i] + MARGIN, column[i] + MARGIN, own[i], window)
        _describe(window, bends, width, step, noise, row_of)
        for f in range(COUNT):
            evidence[k, f] = row_of[f]


@njit(cache=True, nogil=True)
def glance_at(  # type: ignore[no-untyped-def]
    places, points, own, row, column, image, down, across, radius, spread, noise,
    w1, b1, w2, b2, w3, b3, score,
):  # fmt: skip
    """Write what a network of two layers says of the evidence on each of the points.

    The same as `gather_evidence` and three products of matrices, without the room for them:
    most classes of most points are empty, and cost nothing here.
    """
    window, bends = np.empty(SIDE * SIDE, np.float32), np.empty(LINES, np.float32)
    row_of = np.empty(COUNT, np.float32)
    one, two = np.empty(b1.size, np.float32), np.empty(b2.size, np.float32)
    for k in range(places.size):
        i = points[places[k]]
        step = own[i] * math.sqrt(down[column[i]] * across[row[i]])
        width = 2.0 * (radius + own[i] * spread) / step
        _look(image, row[i] + MARGIN, column[i] + MARGIN, own[i], window)
        _describe(window, bends, width, step, noise, row_of)
        _pass_on(row_of, w1, b1, one)
        _pass_on(one, w2, b2, two)
        logit = b3[0]
        for f in range(two.size):
            logit += two[f] * w3[f, 0]
        score[k] = 1.0 / (1.0 + math.exp(-min(max(logit, -30.0), 30.0)))


@njit(cache=True, nogil=True, forceinline=True)
def _pass_on(signal, weight, offset, result):  # type: ignore[no-untyped-def]
    """One layer: weighted sums, those below zero cut off."""
    for f in range(offset.size):
        result[f] = offset[f]
    for n in range(signal.size):
        value = signal[n]
        if value != 0.0:
            for f in range(offset.size):
                result[f] += value * weight[n, f]
    for f in range(offset.size):
        result[f] = max(result[f], np.float32(0.0))


@njit(cache=True, nogil=True, forceinline=True)
def _look(image, y, x, own, window):  # type: ignore[no-untyped-def]
    """Range differences of the beams of the window, row by row."""
    k = 0
    for dy in range(-HALF, HALF + 1):
        for dx in range(-HALF, HALF + 1):
            window[k] = _difference(image, y + dy, x + dx, own)
            k += 1


@njit(cache=True, nogil=True, forceinline=True)
def _describe(window, bends, width, step, noise, found):  # type: ignore[no-untyped-def]
    for f in range(COUNTED):
        found[f] = 0.0
    for k in range(SIDE * SIDE):
        dy, dx = k // SIDE - HALF, k % SIDE - HALF
        near = -1 <= dy <= 1 and -1 <= dx <= 1
        d = window[k]
        if k == CENTRE:
            continue
        if d == d:
            found[_classify(d) + (0 if near else 2 * BINS)] += 0.125 if near else 0.025
        else:
            found[4 * BINS + (0 if near else 1)] += 0.125 if near else 0.025
    for line in range(LINES):
        place = DOWNS[line] * SIDE + ACROSSES[line]
        _keep(bends, line, abs(window[CENTRE + place] + window[CENTRE - place]))
    for n in range(len(KEPT_LINES)):
        found[COUNTED + n] = _shrink(bends[KEPT_LINES[n]])
    for star in range(STARS):
        place = STAR_DOWNS[star] * SIDE + STAR_ACROSSES[star]
        _keep(bends, star, abs(2.0 * window[CENTRE + place] - window[CENTRE + 2 * place]))
    for n in range(len(KEPT_STARS)):
        found[COUNTED + len(KEPT_LINES) + n] = _shrink(bends[KEPT_STARS[n]])
    found[COUNT - 3] = math.log(min(max(width, NARROWEST), WIDEST))
    found[COUNT - 2] = math.log(step / FINEST)
    found[COUNT - 1] = math.log1p(noise / FINEST)
