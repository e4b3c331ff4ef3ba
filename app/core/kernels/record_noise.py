"""Background and noise of a digitised record that holds returns."""

import math

from numba import njit

from app.core.kernels import INNER

FEET = 2
"""Samples beside a return that its foot may reach although they lie below the threshold."""
LOUD = 3.5
"""A sample farther from the background than this many σ is no background."""
ROUNDS = 3
FEWEST_QUIET = 8
TO_SIGMA = 1.482602218505602
"""σ of a normal distribution over its median absolute deviation."""


@njit(**INNER)
def find_noise(samples, span, quantum, scratch):  # type: ignore[no-untyped-def]
    """Background, σ of a sample, and the σ of these two.

    Median and median absolute deviation come first. Samples that stand out from them, and
    those beside these, are signal: the mean and deviation of the rest take their place, as a
    return in the record lifts the median, and whole numbers make the deviation 0 or 1.
    """
    first, end = span
    size = end - first
    if size == 0:
        return math.nan, math.nan, math.nan, math.nan
    for i in range(size):
        scratch[i] = samples[first + i]
    level = select(scratch, size, size >> 1)
    for i in range(size):
        scratch[i] = abs(samples[first + i] - level)
    sigma = add_rounding(TO_SIGMA * select(scratch, size, size >> 1), quantum)
    error, unsure = 1.2533 * sigma / math.sqrt(size), 1.17 * sigma / math.sqrt(size)
    for _ in range(ROUNDS):
        used, total, square = weigh_quiet(samples, span, level, max(LOUD * sigma, quantum))
        if used < FEWEST_QUIET:
            break
        level += total / used
        variance = max(square - total * total / used, 0.0) / (used - 1)
        sigma = add_rounding(math.sqrt(variance), quantum)
        error, unsure = sigma / math.sqrt(used), sigma / math.sqrt(2.0 * used)
    return level, sigma, error, unsure


@njit(**INNER)
def add_rounding(sigma, quantum):  # type: ignore[no-untyped-def]
    """σ with that of rounding, which does not show in a background that hardly moves."""
    return sigma if sigma > 0.5 * quantum else math.hypot(sigma, quantum / math.sqrt(12.0))


@njit(**INNER)
def weigh_quiet(samples, span, level, loud):  # type: ignore[no-untyped-def]
    """Number, sum and sum of squares, from the level, of samples away from any loud one."""
    first, end = span
    used, total, square = 0, 0.0, 0.0
    latest = first - 2 * FEET - 1
    for j in range(first, end + FEET):
        if j < end and abs(samples[j] - level) > loud:
            latest = j
        i = j - FEET
        if i >= first and latest < i - FEET:
            away = samples[i] - level
            used += 1
            total += away
            square += away * away
    return used, total, square


@njit(**INNER)
def select(values, size, k):  # type: ignore[no-untyped-def]
    """The k-th smallest of the first values, which are put in another order (Hoare 1961)."""
    low, high = 0, size - 1
    while low < high:
        pivot = values[(low + high) >> 1]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if k <= j:
            high = j
        elif k >= i:
            low = i
        else:
            break
    return values[k]
