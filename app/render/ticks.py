"""Round numbers for the scale of a colour bar."""

from __future__ import annotations

import math
from itertools import pairwise


def round_ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Multiples of 1, 2, 2.5 or 5 · 10^k between two limits.

    Parameters
    ----------
    low, high : float
    most : int
        Largest number of ticks.

    Returns
    -------
    list of float
        Ascending; empty when the limits hold no range.
    """
    span = high - low
    if not (math.isfinite(span) and span > 0 and most > 0):
        return []
    decade = 10.0 ** math.floor(math.log10(span / most))
    for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0):
        step = decade * factor
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if last - first + 1 <= most:
            return [i * step + 0.0 for i in range(first, last + 1)]
    return []


def label_ticks(ticks: list[float]) -> list[str]:
    """The numbers as text, all with the decimals that tell neighbours apart."""
    if not ticks:
        return []
    step = min((b - a for a, b in pairwise(ticks)), default=abs(ticks[0]))
    largest = max(abs(t) for t in ticks)
    if largest >= 1e6 or (0 < largest < 1e-3):
        return [f"{t:.3g}" for t in ticks]
    decimals = max(0, -math.floor(math.log10(step) + 1e-9)) if step > 0 else 0
    if step > 0 and abs(round(step, decimals) - step) > 1e-9 * step:
        decimals += 1  # steps of 2.5
    return [f"{t:.{decimals}f}".replace("-", "\u2212") for t in ticks]
