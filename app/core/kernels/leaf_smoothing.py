"""Local polynomials of second degree on cells of a leaf.

The weights are Gaussian in rows times Gaussian in columns, so that the sums of a fit are sums
over a column of sums over rows: these are made once for all cells.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER

TERMS = 6
RIDGE = 1e-3
"""Of the diagonal: holds what few cells leave open near to the surface of the whole leaf."""
SPAN = 2.5
"""σ on either side of a cell that its fit looks at."""
POWERS = 5
"""Powers of a distance in the sums of a fit, 0 to 4; its right side has three."""
DOWN, BESIDE = (0, 1, 0, 2, 1, 0), (0, 0, 1, 0, 1, 2)
"""Powers of the distance in rows and in columns of each term."""


@njit(**INNER)
def factor(matrix: AnyArray) -> None:
    """Cholesky factor of a positive matrix, in its lower half."""
    for i in range(TERMS):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i == j:
                matrix[i, i] = math.sqrt(max(total, 1e-300))
            else:
                matrix[i, j] = total / matrix[j, j]


@njit(**INNER)
def solve(matrix: AnyArray, wanted: AnyArray) -> None:
    """Solve with a Cholesky factor, in place."""
    for i in range(TERMS):
        for k in range(i):
            wanted[i] -= matrix[i, k] * wanted[k]
        wanted[i] /= matrix[i, i]
    for i in range(TERMS - 1, -1, -1):
        for k in range(i + 1, TERMS):
            wanted[i] -= matrix[k, i] * wanted[k]
        wanted[i] /= matrix[i, i]


@njit(**INNER)
def spread(normal: AnyArray, squares: AnyArray, axis: int, row: AnyArray) -> float:
    """Variance of a term of a weighted fit, for a variance of 1 of each value."""
    row[:] = 0.0
    row[axis] = 1.0
    solve(normal, row)
    total = 0.0
    for i in range(TERMS):
        for j in range(TERMS):
            total += row[i] * row[j] * squares[max(i, j), min(i, j)]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def sum_rows(value: AnyArray, weight: AnyArray, width: float, lines: AnyArray) -> None:
    """Sums over columns around each cell, `lines` (13, rows, columns), with Gaussian weights.

    0 to 4: the weights times powers of the distance; 5 to 7: these times the values; 8 to 12:
    the squares of the weights.
    """
    rows, columns = value.shape
    wide = int(np.ceil(SPAN * width))
    lines[:] = 0.0
    power = np.empty(POWERS)
    power[0] = 1.0
    for step in range(-wide, wide + 1):
        y = step / width
        for a in range(1, POWERS):
            power[a] = power[a - 1] * y
        gauss = math.exp(-0.5 * y * y)
        for r in range(rows):
            for c in range(max(-step, 0), min(columns - step, columns)):
                w = weight[r, c + step] * gauss
                if w <= 0.0:
                    continue
                for a in range(POWERS):
                    lines[a, r, c] += w * power[a]
                    lines[8 + a, r, c] += w * w * power[a]
                w *= value[r, c + step]
                for a in range(3):
                    lines[5 + a, r, c] += w * power[a]


@njit(cache=True, nogil=True, error_model="numpy")
def sum_up(
    lines: AnyArray, r: int, c: int, width: float, moment: AnyArray, square: AnyArray,
    right: AnyArray,
) -> None:  # fmt: skip
    """Sums over rows of the sums over columns, at one cell."""
    tall = int(np.ceil(SPAN * width))
    moment[:] = 0.0
    square[:] = 0.0
    right[:] = 0.0
    for i in range(max(r - tall, 0), min(r + tall + 1, lines.shape[1])):
        x = (i - r) / width
        gauss = math.exp(-0.5 * x * x)
        heavy, power = gauss, 1.0
        for a in range(POWERS):
            for b in range(POWERS - a):
                moment[a, b] += gauss * power * lines[b, i, c]
                square[a, b] += gauss * gauss * power * lines[8 + b, i, c]
            power *= x
        for a in range(TERMS):
            heavy = gauss if DOWN[a] == 0 else gauss * x if DOWN[a] == 1 else gauss * x * x
            right[a] += heavy * lines[5 + BESIDE[a], i, c]


@njit(cache=True, nogil=True, error_model="numpy")
def leave_out(
    value: AnyArray, weight: AnyArray, r: int, c: int, width: AnyArray, hole: int,
    normal: AnyArray, right: AnyArray, term: AnyArray,
) -> None:  # fmt: skip
    """Take the cells up to `hole` around one out of its sums."""
    for i in range(max(r - hole, 0), min(r + hole + 1, value.shape[0])):
        x = (i - r) / width[0]
        for j in range(max(c - hole, 0), min(c + hole + 1, value.shape[1])):
            y = (j - c) / width[1]
            w = weight[i, j] * math.exp(-0.5 * (x * x + y * y))
            term[0], term[1], term[2] = 1.0, x, y
            term[3], term[4], term[5] = x * x, x * y, y * y
            for a in range(TERMS):
                right[a] -= w * term[a] * value[i, j]
                for b in range(a + 1):
                    normal[a, b] -= w * term[a] * term[b]


@njit(cache=True, nogil=True, error_model="numpy")
def smooth_cells(
    value: AnyArray, weight: AnyArray, asked: AnyArray, width: AnyArray, hole: int,
    lines: AnyArray, found: AnyArray,
) -> None:  # fmt: skip
    """Fit around each asked cell (k, 2); `width` is the Gaussian's σ in rows and columns.

    `lines` are those of `sum_rows`. `found` (k, 5) becomes: value, its change per row and per
    column, and the variances of both changes for a variance of 1 of each value. The cells up to
    `hole` around the asked one are left out; -1 leaves out none.
    """
    normal, squares = np.empty((TERMS, TERMS)), np.empty((TERMS, TERMS))
    moment, square = np.empty((POWERS, POWERS)), np.empty((POWERS, POWERS))
    right, term, row = np.empty(TERMS), np.empty(TERMS), np.empty(TERMS)
    for k in range(asked.shape[0]):
        r, c = asked[k, 0], asked[k, 1]
        sum_up(lines, r, c, width[0], moment, square, right)
        for a in range(TERMS):
            for b in range(a + 1):
                normal[a, b] = moment[DOWN[a] + DOWN[b], BESIDE[a] + BESIDE[b]]
                squares[a, b] = square[DOWN[a] + DOWN[b], BESIDE[a] + BESIDE[b]]
        if hole >= 0:
            leave_out(value, weight, r, c, width, hole, normal, right, term)
        for a in range(TERMS):
            normal[a, a] += RIDGE * normal[0, 0] + 1e-12
        factor(normal)
        solve(normal, right)
        found[k, 0] = right[0]
        found[k, 1] = right[1] / width[0]
        found[k, 2] = right[2] / width[1]
        if hole < 0:
            found[k, 3] = spread(normal, squares, 1, row) / (width[0] * width[0])
            found[k, 4] = spread(normal, squares, 2, row) / (width[1] * width[1])
