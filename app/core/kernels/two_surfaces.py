"""Two surfaces of second degree through the points of one, by turns: fitted, and shared out."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER
from app.core.kernels.leaf_smoothing import TERMS, factor, solve

TURNS = 12
"""Fits and sharings at most; mostly a handful settles."""
AROUND = 2
"""Cells on either side over which squares are averaged before a cell goes to a surface."""
FEWEST = 12
"""Points that a surface of six terms needs."""
CUT = 0.98
"""Share of the squares that are not cut: a few strays must not decide."""
RIDGE = 1e-6
SETTLED = 0.001


@njit(**INNER)
def fit_owned(
    terms: AnyArray, depth: AnyArray, owner: AnyArray, which: int, normal: AnyArray, found: AnyArray
) -> None:
    """Least squares of `depth` over the points of one owner."""
    normal[:] = 0.0
    found[:] = 0.0
    count = 0
    for p in range(depth.size):
        if owner[p] != which:
            continue
        count += 1
        for a in range(TERMS):
            found[a] += terms[p, a] * depth[p]
            for b in range(a + 1):
                normal[a, b] += terms[p, a] * terms[p, b]
    for a in range(TERMS):
        normal[a, a] += RIDGE * count + 1e-12
    factor(normal)
    solve(normal, found)


@njit(**INNER)
def square_off(terms: AnyArray, depth: AnyArray, p: int, found: AnyArray) -> float:
    """Square of how far point p is off a surface."""
    total = -depth[p]
    for a in range(TERMS):
        total += terms[p, a] * found[a]
    return float(total * total)


@njit(cache=True, nogil=True)
def spread_squares(sheet: AnyArray, rows: AnyArray) -> None:
    """Sum a sheet over the window around each cell, in place; `rows` is a sheet to work in."""
    height, width = sheet.shape
    for i in range(height):
        for j in range(width):
            total = 0.0
            for k in range(max(j - AROUND, 0), min(j + AROUND + 1, width)):
                total += sheet[i, k]
            rows[i, j] = total
    for i in range(height):
        for j in range(width):
            total = 0.0
            for k in range(max(i - AROUND, 0), min(i + AROUND + 1, height)):
                total += rows[k, j]
            sheet[i, j] = total


@njit(cache=True, nogil=True)
def mean_cut(squares: AnyArray) -> float:
    """Mean of squares, the largest of them cut to where `CUT` of them end."""
    last = min(int(CUT * squares.size), squares.size - 1)
    most = np.partition(squares, last)[last]
    total = 0.0
    for p in range(squares.size):
        total += min(squares[p], most)
    return float(total / squares.size)


@njit(cache=True, nogil=True)
def share_out(
    terms: AnyArray, depth: AnyArray, row: AnyArray, column: AnyArray, found: AnyArray,
    most: float, rounds: int, owner: AnyArray, one: AnyArray, other: AnyArray, work: AnyArray,
) -> int:  # fmt: skip
    """Give each point to the surface that is nearer around it; how many points changed.

    Squares are averaged over the cells around so many times.
    """
    one[:] = 0.0
    other[:] = 0.0
    for p in range(depth.size):
        one[row[p], column[p]] = min(square_off(terms, depth, p, found[0]), most)
        other[row[p], column[p]] = min(square_off(terms, depth, p, found[1]), most)
    for _ in range(rounds):
        spread_squares(one, work)
        spread_squares(other, work)
    changed = 0
    for p in range(depth.size):
        mine = int(other[row[p], column[p]] < one[row[p], column[p]])
        changed += int(mine != owner[p])
        owner[p] = mine
    return changed


@njit(cache=True, nogil=True, error_model="numpy")
def fit_one(terms: AnyArray, depth: AnyArray) -> float:
    """Mean square off one surface through all points."""
    owner = np.zeros(depth.size, np.int64)
    normal, found = np.empty((TERMS, TERMS)), np.empty(TERMS)
    fit_owned(terms, depth, owner, 0, normal, found)
    squares = np.empty(depth.size)
    for p in range(depth.size):
        squares[p] = square_off(terms, depth, p, found)
    return float(mean_cut(squares))


@njit(cache=True, nogil=True, error_model="numpy")
def fit_two(
    terms: AnyArray, depth: AnyArray, row: AnyArray, column: AnyArray, starts: AnyArray,
    fewest: int, most: float, found: AnyArray, left: AnyArray,
) -> None:  # fmt: skip
    """Two surfaces from each of the starts (k, n), 0 or 1 for each point.

    `found` (k, 2, 6) become their terms, `left` (k,) the mean squares off them; infinite where
    a surface has fewer points than `fewest`.
    """
    shape = row.max() + 1, column.max() + 1
    one, other, work = np.empty(shape), np.empty(shape), np.empty(shape)
    normal = np.empty((TERMS, TERMS))
    squares, owner = np.empty(depth.size), np.empty(depth.size, np.int64)
    for k in range(starts.shape[0]):
        left[k] = math.inf
        owner[:] = starts[k]
        for _ in range(TURNS):
            second = owner.sum()
            if min(second, owner.size - second) < fewest:
                break
            for which in range(2):
                fit_owned(terms, depth, owner, which, normal, found[k, which])
            changed = share_out(
                terms, depth, row, column, found[k], most, 1, owner, one, other, work
            )
            if changed <= SETTLED * owner.size:
                break
        second = owner.sum()
        if min(second, owner.size - second) < fewest:
            continue
        for p in range(depth.size):
            squares[p] = square_off(terms, depth, p, found[k, owner[p]])
        left[k] = mean_cut(squares)
