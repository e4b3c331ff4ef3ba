"""Points sorted by voxel, and planes from the 27 voxels around a point."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels.plane import SUMS, add_ball, covers_area, store_plane

BITS = 21
HALF = 1 << (BITS - 1)


@njit(cache=True, nogil=True)
def voxel_keys(xyz: AnyArray, points: AnyArray, centre: AnyArray, cell: float) -> AnyArray:
    """One integer per point that sorts by voxel x, then y, then z.

    Voxels too far from the centre for 21 bits share the outermost one: neighbours stay
    neighbours, so that far outliers cost time and never a neighbour.
    """
    keys = np.empty(points.size, np.int64)
    for k in range(points.size):
        key = np.int64(0)
        for axis in range(3):
            step = math.floor((xyz[points[k], axis] - centre[axis]) / cell)
            step = min(max(step, float(2 - HALF)), float(HALF - 3))
            key = (key << BITS) | (np.int64(step) + HALF)
        keys[k] = key
    return keys


@njit(cache=True, nogil=True)
def mark_boxes(
    xyz: AnyArray, points: AnyArray, low: AnyArray, size: float, marks: AnyArray
) -> None:
    """Mark the box of each asked point, and the 26 around it."""
    for i in points:
        bx = int((xyz[i, 0] - low[0]) / size)
        by = int((xyz[i, 1] - low[1]) / size)
        bz = int((xyz[i, 2] - low[2]) / size)
        if not marks[1, bx, by, bz]:
            marks[1, bx, by, bz] = True
            for ix in range(max(bx - 1, 0), min(bx + 2, marks.shape[1])):
                for iy in range(max(by - 1, 0), min(by + 2, marks.shape[2])):
                    for iz in range(max(bz - 1, 0), min(bz + 2, marks.shape[3])):
                        marks[0, ix, iy, iz] = True


@njit(cache=True, nogil=True)
def usable_in_boxes(
    xyz: AnyArray, scanner: AnyArray, low: AnyArray, size: float, marks: AnyArray
) -> AnyArray:
    """Numbers of the points with a range that lie in marked boxes."""
    kept = np.empty(len(xyz), np.int64)
    total = 0
    nx, ny, nz = marks.shape[1:]
    for i in range(len(xyz)):
        fx = (xyz[i, 0] - low[0]) / size
        fy = (xyz[i, 1] - low[1]) / size
        fz = (xyz[i, 2] - low[2]) / size
        if not (0.0 <= fx < nx and 0.0 <= fy < ny and 0.0 <= fz < nz):
            continue
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        if marks[0, int(fx), int(fy), int(fz)] and dx * dx + dy * dy + dz * dz > 0.0:
            kept[total] = i
            total += 1
    return kept[:total].copy()


@njit(cache=True, nogil=True)
def _offset(k: int) -> int:
    """From a voxel's key to that of the k-th of the nine columns of voxels around it."""
    return ((k // 3 - 1) << (2 * BITS)) + ((k % 3 - 1) << BITS)


@njit(cache=True, nogil=True)
def _advance(keys: AnyArray, v: int, runs: AnyArray) -> None:
    """Move the nine runs on to the voxels around voxel v."""
    for k in range(9):
        key = keys[v] + _offset(k)
        low, high = runs[k, 0], runs[k, 1]
        while low < keys.size and keys[low] < key - 1:
            low += 1
        high = max(low, high)
        while high < keys.size and keys[high] <= key + 1:
            high += 1
        runs[k, 0], runs[k, 1] = low, high


@njit(cache=True, nogil=True)
def _grow_ball(
    x: AnyArray, y: AnyArray, z: AnyArray, start: AnyArray, runs: AnyArray, p: int,
    scanner: AnyArray, widths: AnyArray, enough: int, sums: AnyArray,
) -> float:  # fmt: skip
    """Sum balls of rising width around p until one holds enough; the last width tried."""
    radius = 0.0
    for radius in widths:
        sums[:] = 0.0
        for k in range(9):
            add_ball(
                x, y, z, start[runs[k, 0]], start[runs[k, 1]], 1,
                x[p], y[p], z[p], radius * radius, sums,
            )  # fmt: skip
        if sums[0] >= enough and covers_area(sums, x[p], y[p], z[p], scanner, radius):
            break
    return radius


@njit(cache=True, nogil=True)
def fit_in_voxels(
    x: AnyArray, y: AnyArray, z: AnyArray, member: AnyArray, keys: AnyArray, start: AnyArray,
    slot: AnyArray, first: int, last: int, scanner: AnyArray, widths: AnyArray, enough: int,
    final: bool, normals: AnyArray, count: AnyArray, width: AnyArray, rms: AnyArray,
) -> None:  # fmt: skip
    """Planes of the points in the voxels `first` to `last`.

    Voxels are sorted, so those around one lie in nine runs of the list, and the ends of the
    runs only move forward from voxel to voxel: no search, no hash table. A slot is left
    undone (width 0) when its ball does not hold `enough` points, unless this is the `final` try.
    """
    sums = np.empty(SUMS)
    runs = np.zeros((9, 2), np.int64)
    for k in range(9):
        runs[k] = np.searchsorted(keys, keys[first] + _offset(k) - 1)
    for v in range(first, last):
        _advance(keys, v, runs)
        for p in range(start[v], start[v + 1]):
            s = slot[member[p]]
            if s < 0 or width[s] > 0.0:
                continue
            radius = _grow_ball(x, y, z, start, runs, p, scanner, widths, enough, sums)
            defined = covers_area(sums, x[p], y[p], z[p], scanner, radius)
            if (sums[0] >= enough and defined) or final:
                count[s] = int(sums[0])
                width[s] = radius
                if defined:
                    rms[s] = store_plane(sums, x[p], y[p], z[p], scanner, normals[s])
