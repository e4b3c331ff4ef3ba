"""Many roots at once, each in a bracket of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.core.arrays import Floats, Ints

MOST_STEPS = 80
CLOSE = 1e-14


def find_roots(
    slope: Callable[[Floats, Ints], Floats],
    low: Floats,
    high: Floats,
    at: tuple[Floats, Floats],
    close: float = CLOSE,
) -> Floats:
    """Zeros of functions of one number, each between two values of different sign.

    Parameters
    ----------
    slope : callable
        Value at `x`, (r,), of the functions with the numbers `which`, (r,).
    low, high : (c,) arrays
        Brackets.
    at : two (c,) arrays
        Values at `low` and `high`, of opposite signs.
    close : float
        Relative width of a bracket that is narrow enough.

    Returns
    -------
    (c,) array
        Chandrupatla's method (Adv. Eng. Softw. 28 (1997) 145): inverse quadratic steps where
        they are safe, halving where they are not.
    """
    result = np.where(np.abs(at[0]) < np.abs(at[1]), low, high)
    todo: Ints = np.arange(len(low))
    x1, x2, f1, f2 = low.copy(), high.copy(), at[0].copy(), at[1].copy()
    share = np.clip(f1 / (f1 - f2), 0.05, 0.95) if len(low) else low
    for _ in range(MOST_STEPS):
        if not len(todo):
            break
        x = x1 + share * (x2 - x1)
        f = slope(x, todo)
        same = np.sign(f) == np.sign(f1)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, f
        best = np.where(np.abs(f2) < np.abs(f1), x2, x1)
        result[todo] = best
        least = 0.5 * close * np.abs(best) / np.maximum(np.abs(x2 - x1), np.finfo(float).tiny)
        going = (least < 0.5) & (f1 != 0.0)
        x1, x2, x3, f1, f2, f3, least, todo = (
            array[going] for array in (x1, x2, x3, f1, f2, f3, least, todo)
        )
        share = np.clip(_choose_share((x1, x2, x3), (f1, f2, f3)), least, 1.0 - least)
    return result


def _choose_share(x: tuple[Floats, Floats, Floats], f: tuple[Floats, Floats, Floats]) -> Floats:
    """How far to go from x₁ to x₂: by inverse quadratic interpolation where that is monotone."""
    (x1, x2, x3), (f1, f2, f3) = x, f
    with np.errstate(divide="ignore", invalid="ignore"):
        place, height = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        safe = (1 - np.sqrt(1 - place) < height) & (height < np.sqrt(place))
        along = (x3 - x1) / (x2 - x1)
        share = f1 / (f1 - f2) * f3 / (f3 - f2) - along * f1 / (f3 - f1) * f2 / (f2 - f3)
    return np.where(safe & np.isfinite(share), share, 0.5)
