"""Values of points laid out in rows and columns, with a margin, one layer for each return."""

from __future__ import annotations

import math

from numba import njit

MARGIN = 8
"""Cells without a beam around the image, so that no window leaves it."""
MOST_LAYERS = 4
"""Returns of one beam that are looked at; scanners that tell more are rare."""


@njit(cache=True, nogil=True)
def measure_ranges(xyz, scanner, own):  # type: ignore[no-untyped-def]
    """Write the distance of each point from the scanner."""
    for i in range(own.size):
        x, y, z = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        own[i] = math.sqrt(x * x + y * y + z * z)


@njit(cache=True, nogil=True)
def lay_ranges(own, row, column, layer, image):  # type: ignore[no-untyped-def]
    """Write the ranges that are some into (layers, rows, columns) with their margin.

    Gives whether a place was taken already.
    """
    taken = False
    for i in range(own.size):
        if layer[i] < image.shape[0] and 0.0 < own[i] < math.inf:
            y, x = row[i] + MARGIN, column[i] + MARGIN
            taken |= image[layer[i], y, x] == image[layer[i], y, x]
            image[layer[i], y, x] = own[i]
    return taken


@njit(cache=True, nogil=True)
def lay_values(values, row, column, layer, laid):  # type: ignore[no-untyped-def]
    """Write values of the points into an array of that shape."""
    for i in range(values.size):
        if layer[i] < laid.shape[0]:
            laid[layer[i], row[i] + MARGIN, column[i] + MARGIN] = values[i]
