"""Angle from intensity, where a curve is monotone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.core.arrays import Bools, Floats, Ints

Curve = Callable[[Floats], Floats]

CELLS = 1800
STEPS = 60
ANGLE_TOLERANCE = 1e-14


def find_monotone_interval(slope: Curve, start: float, stop: float) -> tuple[float, float] | None:
    """Widest interval within [start, stop] on which a curve only falls or only rises.

    Parameters
    ----------
    slope : callable
        Derivative of the curve. Turning points closer than 1/1800 of the range are missed.
    start, stop : float
        Radians.

    Returns
    -------
    (float, float) or None
        None when there is no such interval (a flat curve, an empty range).
    """
    if not stop > start:
        return None
    edges = np.linspace(start, stop, CELLS + 1)
    middles = (edges[:-1] + edges[1:]) / 2
    sign = np.sign(slope(middles))
    breaks = np.flatnonzero(sign[1:] != sign[:-1])
    first = np.concatenate(([0], breaks + 1))
    last = np.concatenate((breaks, [CELLS - 1]))
    usable = np.abs(sign[first]) == 1.0
    if not usable.any():
        return None
    first, last = first[usable], last[usable]
    best = int(np.argmax(last - first))
    i, j = int(first[best]), int(last[best])
    low = start if i == 0 else _find_turn(slope, middles[i], middles[i - 1])
    high = stop if j == CELLS - 1 else _find_turn(slope, middles[j], middles[j + 1])
    return low, high


def _find_turn(slope: Curve, inside: float, outside: float) -> float:
    sign = np.sign(slope(np.array([inside]))[0])
    for _ in range(STEPS):
        middle = (inside + outside) / 2
        if np.sign(slope(np.array([middle]))[0]) == sign:
            inside = middle
        else:
            outside = middle
    return float(inside)


def invert_monotone(
    curve: Curve, slope: Curve, value: Floats, interval: tuple[float, float]
) -> Floats:
    """Solve curve(ω) = value on an interval on which the curve is monotone.

    A table brackets each value; Newton steps that stay in the bracket, and halving where they
    do not, finish it.

    Parameters
    ----------
    curve, slope : callable
    value : array of any shape
    interval : (float, float)
        Radians.

    Returns
    -------
    array
        Of the shape of `value`; NaN where the value is not reached, or is NaN.
    """
    edges = np.linspace(*interval, CELLS + 1)
    table = curve(edges)
    falls = table[0] > table[-1]
    table, edges = (table[::-1], edges[::-1]) if falls else (table, edges)
    slack = 4 * np.finfo(float).eps * np.abs(table[[0, -1]]).max()
    flat = value.ravel()
    reached = (flat >= table[0] - slack) & (flat <= table[-1] + slack)
    wanted = np.clip(flat[reached], table[0], table[-1])
    cell = np.clip(np.searchsorted(table, wanted, side="right") - 1, 0, CELLS - 1)
    result = np.full(flat.shape, np.nan)
    result[reached] = _polish(curve, slope, wanted, edges, table, cell)
    return result.reshape(value.shape)


def _polish(
    curve: Curve, slope: Curve, wanted: Floats, edges: Floats, table: Floats, cell: Ints
) -> Floats:
    """Angles of `wanted`, each within its cell; `below` holds the end with the lower value."""
    below, above = edges[cell], edges[cell + 1]
    rise = table[cell + 1] - table[cell]
    share = np.divide(wanted - table[cell], rise, out=np.full_like(rise, 0.5), where=rise > 0)
    angle = below + share * (above - below)
    todo = np.arange(len(wanted))
    for _ in range(STEPS):
        now = angle[todo]
        miss = curve(now) - wanted[todo]
        low: Bools = miss <= 0
        below[todo] = np.where(low, now, below[todo])
        above[todo] = np.where(low, above[todo], now)
        after = _step(now, miss, slope(now), below[todo], above[todo])
        angle[todo] = after
        todo = todo[(np.abs(after - now) > ANGLE_TOLERANCE) & (miss != 0)]
        if not len(todo):
            break
    return angle


def _step(now: Floats, miss: Floats, slope: Floats, below: Floats, above: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore"):
        newton = now - miss / slope
    inside = (newton >= np.minimum(below, above)) & (newton <= np.maximum(below, above))
    halved = np.where(miss == 0, now, (below + above) / 2)
    return np.where(inside, newton, halved)
