"""Connected surfaces on a scan grid, by union and find."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray

SLOPE = 3.0
"""Tangent up to which neighbouring beams belong to one surface, 72°."""


@njit(cache=True, nogil=True)
def find_root(parent: AnyArray, p: int) -> int:
    """Root of p, halving the path on the way."""
    while parent[p] != p:
        parent[p] = parent[parent[p]]
        p = parent[p]
    return p


@njit(cache=True, nogil=True)
def join_cells(
    distance: AnyArray, usable: AnyArray, start: AnyArray, row: AnyArray, column: AnyArray,
    member: AnyArray, parent: AnyArray, first: int, last: int, down: AnyArray, across: AnyArray,
    seam: bool, jump: float,
) -> None:  # fmt: skip
    """Join each sorted point with those of the cells to the right, below, and below beside."""
    rows, columns = across.size, down.size
    for p in range(first, last):
        if not usable[p]:
            continue
        r, c = row[member[p]], column[member[p]]
        for k in range(4):
            dr, dc = (0, 1) if k == 0 else (1, k - 2)
            r1, c1 = r + dr, c + dc
            if seam:
                c1 = c1 % columns
            if r1 >= rows or not 0 <= c1 < columns:
                continue
            cell = np.int64(r1) * columns + c1
            reach = math.hypot(dr * down[c], dc * across[r]) * distance[p]
            for q in range(start[cell], start[cell + 1]):
                if usable[q] and abs(distance[q] - distance[p]) <= max(jump, SLOPE * reach):
                    a, b = find_root(parent, p), find_root(parent, q)
                    parent[max(a, b)] = min(a, b)


@njit(cache=True, nogil=True)
def flatten_roots(parent: AnyArray) -> None:
    """Point every entry at its root."""
    for p in range(parent.size):
        parent[p] = find_root(parent, p)
