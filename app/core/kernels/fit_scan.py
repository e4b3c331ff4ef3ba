"""Sums of squares of many groups at many trial shapes: the linear part solved for each."""

import math

from numba import njit
from numpy import empty, inf, isfinite

from app.core.arrays import AnyArray
from app.core.fitting.linear import DEPENDENT

MATH = {"contract", "reassoc", "arcp", "nsz"}
"""NaN must stay NaN."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def scan_groups(
    columns: AnyArray, target: AnyArray, root: AnyArray, bounds: AnyArray, rss: AnyArray
) -> None:
    """Fill `rss`, (g, s), as `solve_bounded` would.

    `columns` (g or 1, s, j, n), `target` (g, s or 1, n), `root` (g or 1, n) and `bounds`
    (g or 1, 2, j): an axis of length 1 serves all.
    """
    j, n = columns.shape[2], columns.shape[3]
    weighted, q, r = empty((j, n)), empty((j, n)), empty((j, j))
    goal, rest, best = empty(n), empty(n), empty(j)
    shared = len(columns) == 1 and len(root) == 1
    for s in range(rss.shape[1]):
        for g in range(rss.shape[0]):
            w = root[g if len(root) > 1 else 0]
            if g == 0 or not shared:
                _factor(columns[g if len(columns) > 1 else 0, s], w, weighted, q, r)
            wanted = target[g, s if target.shape[1] > 1 else 0]
            for i in range(n):
                goal[i] = wanted[i] * w[i]
                rest[i] = goal[i]
            rss[g, s] = _project(q, r, rest, best)
            limits = bounds[g if len(bounds) > 1 else 0]
            if _is_outside(best, limits):
                rss[g, s] = _search_edges(weighted, goal, limits)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def _factor(columns: AnyArray, w: AnyArray, weighted: AnyArray, q: AnyArray, r: AnyArray) -> None:
    """Modified Gram–Schmidt of the weighted columns: q and the triangle r."""
    count, n = columns.shape
    for j in range(count):
        start = 0.0
        for i in range(n):
            weighted[j, i] = columns[j, i] * w[i]
            q[j, i] = weighted[j, i]
            start += q[j, i] * q[j, i]
        r[j, j] = math.sqrt(start)
    for j in range(count):
        square = 0.0
        for i in range(n):
            square += q[j, i] * q[j, i]
        length = math.sqrt(square)
        told = length > DEPENDENT * r[j, j]
        scale = 1.0 / length if told else 0.0
        r[j, j] = length if told else 1.0
        for i in range(n):
            q[j, i] *= scale
        for k in range(j + 1, count):
            along = 0.0
            for i in range(n):
                along += q[j, i] * q[k, i]
            for i in range(n):
                q[k, i] -= along * q[j, i]
            r[j, k] = along


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def _project(q: AnyArray, r: AnyArray, rest: AnyArray, best: AnyArray) -> float:
    """`best` gets the coefficients, `rest` the residuals; their sum of squares is returned."""
    count, n = q.shape
    for j in range(count):
        along = 0.0
        for i in range(n):
            along += q[j, i] * rest[i]
        for i in range(n):
            rest[i] -= along * q[j, i]
        best[j] = along
    for j in range(count - 1, -1, -1):
        for k in range(j + 1, count):
            best[j] -= r[j, k] * best[k]
        best[j] /= r[j, j]
    rss = 0.0
    for i in range(n):
        rss += rest[i] * rest[i]
    return rss


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def _search_edges(columns: AnyArray, goal: AnyArray, limits: AnyArray) -> float:
    """Least sum of squares with one of at most two coefficients on a bound."""
    count, n = columns.shape
    least = inf
    for j in range(count):
        for side in range(2):
            bound = limits[side, j]
            if not isfinite(bound):
                continue
            other, ideal = count - 1 - j, 0.0
            if count > 1:
                square, along = 0.0, 0.0
                for i in range(n):
                    square += columns[other, i] * columns[other, i]
                    along += columns[other, i] * (goal[i] - bound * columns[j, i])
                if square > 0.0:
                    ideal = along / square
                ideal = min(max(ideal, limits[0, other]), limits[1, other])
            total = 0.0
            for i in range(n):
                miss = goal[i] - bound * columns[j, i]
                if count > 1:
                    miss -= ideal * columns[other, i]
                total += miss * miss
            least = min(least, total)
    return least


@njit(cache=True, nogil=True, error_model="numpy")
def _is_outside(best: AnyArray, limits: AnyArray) -> bool:
    outside = False
    for j in range(len(best)):
        outside = outside or best[j] < limits[0, j] or best[j] > limits[1, j]
    return outside
