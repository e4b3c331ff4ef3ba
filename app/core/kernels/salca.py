"""The root of SALCA's response: Newton's method from the left, kept between two bounds."""

import math

from numba import njit
from numpy import empty, nan

from app.core.arrays import AnyArray

STEPS = 100
"""Newton takes 3 to 6; halving alone would come down to the last digit within these."""
CLOSE = 4e-16
"""Relative step at which the last digit is reached."""
SETTLED = 40.0
"""k·x from which on the exponential no longer counts in a double."""


@njit(cache=True, nogil=True, error_model="numpy")
def invert_salca(y: AnyArray, m: float, c: float, k: float, brightest: float) -> AnyArray:
    """X with (m x + c)(1 − e^(−k x)) = y, each between 0 and `brightest`; NaN where none is."""
    x = empty(len(y))
    top = -(m * brightest + c) * math.expm1(-k * brightest)
    for i in range(len(y)):
        x[i] = nan
        if 0.0 < y[i] <= top:
            x[i] = _find_root(y[i], m, c, k, brightest)
    return x


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def _find_root(y: float, m: float, c: float, k: float, brightest: float) -> float:
    low = max(0.0, (y - c) / m)
    high = min(brightest, low + SETTLED / k)
    # With x no larger than `high`, the bracket c + m x is no larger than here: a start that
    # lies left of the root, from where Newton on a concave curve never jumps over it.
    start = -math.log1p(-min(y / (c + m * high), 1.0 - 1e-16)) / k
    x = min(max(low, start), high)
    for _ in range(STEPS):
        fall = math.expm1(-k * x)
        line = m * x + c
        value = -line * fall - y
        if value < 0.0:
            low = x
        else:
            high = x
        new = x - value / (-m * fall + line * k * (1.0 + fall))
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - x) <= CLOSE * new:
            return new
        x = new
    return x
