"""Networks of two layers and a sum, for many rows: in batches, one lane each.

A library's product of matrices starts threads of its own for these; here the threads that
share the points do the work.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

LANES = 64
LARGEST = np.float32(30.0)
"""Of the logit: beyond it, a probability is 0 or 1 to all digits."""


@njit(cache=True, nogil=True, fastmath={"contract"})
def pass_on(signal, weight, offset, result, least):  # type: ignore[no-untyped-def]
    """One layer: weighted sums of (inputs, LANES), those below the least cut off."""
    inputs = signal.shape[0]
    whole = inputs - inputs % 4
    for f in range(offset.size):
        for p in range(LANES):
            result[f, p] = offset[f]
        for n in range(0, whole, 4):
            a, b, c, d = weight[n, f], weight[n + 1, f], weight[n + 2, f], weight[n + 3, f]
            for p in range(LANES):
                result[f, p] += (a * signal[n, p] + b * signal[n + 1, p]) + (
                    c * signal[n + 2, p] + d * signal[n + 3, p]
                )
        for n in range(whole, inputs):
            a = weight[n, f]
            for p in range(LANES):
                result[f, p] += a * signal[n, p]
        for p in range(LANES):
            result[f, p] = max(result[f, p], least)


@njit(cache=True, nogil=True, forceinline=True)
def weigh_lanes(  # type: ignore[no-untyped-def]
    signal, w1, b1, w2, b2, w3, b3, one, two, last, said, start, size
):
    """Write the probabilities of the first lanes; `one`, `two`, `last` are room for layers."""
    pass_on(signal, w1, b1, one, np.float32(0.0))
    pass_on(one, w2, b2, two, np.float32(0.0))
    pass_on(two, w3, b3, last, -LARGEST)
    for p in range(size):
        said[start + p] = 1.0 / (1.0 + math.exp(-min(last[0, p], LARGEST)))


@njit(cache=True, nogil=True)
def weigh(rows, w1, b1, w2, b2, w3, b3, said):  # type: ignore[no-untyped-def]
    """Write the probability that each row of numbers tells, (rows,)."""
    signal = np.zeros((rows.shape[1], LANES), np.float32)
    one, two = np.empty((b1.size, LANES), np.float32), np.empty((b2.size, LANES), np.float32)
    last = np.empty((1, LANES), np.float32)
    for start in range(0, rows.shape[0], LANES):
        size = min(LANES, rows.shape[0] - start)
        for p in range(size):
            for n in range(rows.shape[1]):
                signal[n, p] = rows[start + p, n]
        weigh_lanes(signal, w1, b1, w2, b2, w3, b3, one, two, last, said, start, size)
