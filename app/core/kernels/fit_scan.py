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
    weighted, q = empty((j, n)), empty((j, n))
    goal, rest = empty(n), empty(n)
    best = empty(j)
    for g in range(rss.shape[0]):
        limits = bounds[g if len(bounds) > 1 else 0]
        w = root[g if len(root) > 1 else 0]
        for s in range(rss.shape[1]):
            table = columns[g if len(columns) > 1 else 0, s]
            wanted = target[g, s if target.shape[1] > 1 else 0]
            for i in range(n):
                goal[i] = wanted[i] * w[i]
                rest[i] = goal[i]
            for k in range(j):
                for i in range(n):
                    weighted[k, i] = table[k, i] * w[i]
                    q[k, i] = weighted[k, i]
            rss[g, s] = _solve_free(q, rest, best)
            if _is_outside(best, limits):
                rss[g, s] = _search_edges(weighted, goal, limits)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def _solve_free(q: AnyArray, rest: AnyArray, best: AnyArray) -> float:
    """Modified Gram–Schmidt; `best` gets the coefficients, the sum of squares is returned."""
    count, n = q.shape
    r = empty((count, count))
    for j in range(count):
        start = _dot(q[j], q[j])
        r[j, j] = math.sqrt(start)
    for j in range(count):
        length = math.sqrt(_dot(q[j], q[j]))
        told = length > DEPENDENT * r[j, j]
        scale = 1.0 / length if told else 0.0
        r[j, j] = length if told else 1.0
        for i in range(n):
            q[j, i] *= scale
        for k in range(j + 1, count):
            r[j, k] = _dot(q[j], q[k])
            for i in range(n):
                q[k, i] -= r[j, k] * q[j, i]
        best[j] = _dot(q[j], rest)
        for i in range(n):
            rest[i] -= best[j] * q[j, i]
    for j in range(count - 1, -1, -1):
        for k in range(j + 1, count):
            best[j] -= r[j, k] * best[k]
        best[j] /= r[j, j]
    return _dot(rest, rest)


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
    for j in range(len(best)):
        if best[j] < limits[0, j] or best[j] > limits[1, j]:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy", fastmath=MATH)
def _dot(a: AnyArray, b: AnyArray) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total
