"""A piece of a range image: 1 / range, marks beside holes and jumps, and sums over both.

Sums over any window of it come from four corners of a table (integral image).
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.normals.rules import HALO


class Image(NamedTuple):
    """A range image and its beams, and its points."""

    inverse: Any  # (rows, columns) 1 / m; 0 without a point
    number: Any  # (rows, columns) number of the point, from 1; 0 without
    down: Any  # (rows,) elevation to the next row
    turn: Any  # (columns,) azimuth to the next column
    level: Any  # (rows,) cosine of the elevation
    uneven_row: Any  # (rows,) bool: the step changes near
    uneven_column: Any  # (columns,)
    axes: Any  # (3, 3) scanner's axes as rows
    seam: bool  # the last column lies beside the first
    xyz: Any  # (n, 3)
    scanner: Any  # (3,)


class Tile(NamedTuple):
    """A rectangle of cells with its halo, and the sums over it; memory for the largest."""

    w: Any  # (n, n) 1 / range less `base`; 0 in holes
    marks: Any  # (n, n) holes, and cells beside jumps
    bad: Any  # (n + 1, n + 1) integral of the marks
    sums: Any  # (n + 1, n + 1, 4) integrals of w, row · w, column · w, w²


@njit(**INNER)
def make_tile(size):  # type: ignore[no-untyped-def]
    """Memory for a tile of size × size cells, halo included."""
    return Tile(
        np.empty((size, size)), np.empty((size, size), np.uint8),
        np.zeros((size + 1, size + 1), np.int32), np.zeros((size + 1, size + 1, 4)),
    )  # fmt: skip


@njit(**INNER)
def load_tile(image, place, tile, slope, noise):  # type: ignore[no-untyped-def]
    """Copy a rectangle (rows and columns from, to) and its halo, mark and integrate; the base.

    The base, the mean of 1 / range, is taken off, so that sums of squares keep their digits.
    """
    rows, columns = image.inverse.shape
    row, column = place[0] - HALO, place[1] - HALO
    inverse, w = image.inverse, tile.w
    tall, broad = place[2] - row + HALO, place[3] - column + HALO
    total = 0.0
    count = 0
    for i in range(tall):
        r = row + i
        for j in range(broad):
            c = column + j
            if image.seam:
                c = c % columns
            v = inverse[r, c] if 0 <= r < rows and 0 <= c < columns else 0.0
            w[i, j] = v
            total += v
            count += v > 0.0
    base = total / max(count, 1)
    mark_breaks(image, row, column, tall, broad, tile, slope, noise)
    for i in range(tall):
        for j in range(broad):
            v = w[i, j]
            w[i, j] = v - base if v > 0.0 else 0.0
    integrate(tile, tall, broad)
    return base


@njit(**INNER)
def mark_breaks(image, row, column, tall, broad, tile, slope, noise):  # type: ignore[no-untyped-def]
    """Mark holes, and two cells on both sides of a jump; then integrate the marks."""
    w, bad, marks = tile.w, tile.bad, tile.marks
    for i in range(tall):  # plain loops: slices take seconds to compile
        for j in range(broad):
            marks[i, j] = w[i, j] == 0.0
    mark_jumps(image, row, column, tall, broad, tile, slope, noise)
    for i in range(tall):
        line = 0
        for j in range(broad):
            line += marks[i, j]
            bad[i + 1, j + 1] = bad[i, j + 1] + line


@njit(**INNER)
def mark_jumps(image, row, column, tall, broad, tile, slope, noise):  # type: ignore[no-untyped-def]
    """Mark two cells on both sides of a jump, along rows and along columns."""
    rows, columns = image.inverse.shape
    down, level, turn = image.down, image.level, image.turn
    w, marks = tile.w, tile.marks
    for i in range(tall):
        r = min(max(row + i, 0), rows - 1)
        for j in range(broad):
            v = w[i, j]
            if v == 0.0:
                continue
            right = w[i, j + 1] if j + 1 < broad else 0.0
            side = turn[(column + j) % columns] * level[r]
            if right > 0.0 and jumps(v, right, side, slope, noise):
                for k in range(max(j - 1, 0), min(j + 3, broad)):
                    marks[i, k] = 1
            below = w[i + 1, j] if i + 1 < tall else 0.0
            if below > 0.0 and jumps(v, below, down[r], slope, noise):
                for k in range(max(i - 1, 0), min(i + 3, tall)):
                    marks[k, j] = 1


@njit(**INNER, forceinline=True)
def jumps(v, w, step, slope, noise):  # type: ignore[no-untyped-def]
    """Whether the ranges 1 / v and 1 / w differ by more than noise and a steep surface explain."""
    # |1/w - 1/v| > |step| slope / v + noise, times v w: no division.
    return abs(v - w) > (abs(step) * slope + noise * v) * w


@njit(**INNER, forceinline=True)
def gate(r, step, slope, noise):  # type: ignore[no-untyped-def]
    """Change of range from cell to cell that noise and a steep surface explain."""
    return r * abs(step) * slope + noise


@njit(**INNER)
def integrate(tile, tall, broad):  # type: ignore[no-untyped-def]
    """Fill the integral image; its first row and column stay zero."""
    w, s = tile.w, tile.sums
    for i in range(tall):
        a = b = c = d = 0.0
        for j in range(broad):
            v = w[i, j]
            a += v
            b += v * i
            c += v * j
            d += v * v
            s[i + 1, j + 1, 0] = s[i, j + 1, 0] + a
            s[i + 1, j + 1, 1] = s[i, j + 1, 1] + b
            s[i + 1, j + 1, 2] = s[i, j + 1, 2] + c
            s[i + 1, j + 1, 3] = s[i, j + 1, 3] + d
