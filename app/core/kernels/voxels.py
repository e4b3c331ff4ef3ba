"""Points sorted by voxel, and planes from the 27 voxels around a point."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER
from app.core.kernels.plane import (
    LANES,
    PLANES,
    SUMS,
    covers_area,
    solve_lanes,
    store_plane,
    sum_ball,
)

BITS = 21
HALF = 1 << (BITS - 1)


@njit(cache=True, nogil=True)
def find_usable(xyz: AnyArray, scanner: AnyArray, first: int, last: int, usable: AnyArray) -> None:
    """Say of the points `first` to `last` which have a finite range above zero."""
    for i in range(first, last):
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        usable[i] = 0.0 < dx * dx + dy * dy + dz * dz < math.inf


@njit(cache=True, nogil=True)
def voxel_keys(
    xyz: AnyArray, points: AnyArray, centre: AnyArray, cell: float, first: int, last: int,
    keys: AnyArray,
) -> None:  # fmt: skip
    """One integer for each of points[first:last] that sorts by voxel x, then y, then z.

    Voxels too far from the centre for 21 bits share the outermost one: neighbours stay
    neighbours, so that far outliers cost time and never a neighbour.
    """
    for k in range(first, last):
        key = np.int64(0)
        for axis in range(3):
            step = np.floor((xyz[points[k], axis] - centre[axis]) / cell)
            step = min(max(step, float(2 - HALF)), float(HALF - 3))
            key = (key << BITS) | (np.int64(step) + HALF)
        keys[k] = key


@njit(cache=True, nogil=True)
def take_points(
    xyz: AnyArray, points: AnyArray, keys: AnyArray, order: AnyArray, at: int, x: AnyArray,
    y: AnyArray, z: AnyArray, member: AnyArray, sorted_keys: AnyArray,
) -> None:  # fmt: skip
    """Copy points in sorted order to place `at` and on."""
    for k in range(order.size):
        i = points[order[k]]
        x[at + k], y[at + k], z[at + k] = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        member[at + k] = i
        sorted_keys[at + k] = keys[order[k]]


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


@njit(**INNER)
def _offset(k: int) -> int:
    """From a voxel's key to that of the k-th of the nine columns of voxels around it."""
    return ((k // 3 - 1) << (2 * BITS)) + ((k % 3 - 1) << BITS)


@njit(**INNER)
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


@njit(**INNER)
def _gather(
    x: AnyArray, y: AnyArray, z: AnyArray, start: AnyArray, runs: AnyArray, first: int, last: int,
    reach: float, near: AnyArray,
) -> tuple[AnyArray, int]:  # fmt: skip
    """Copy the points of the runs within `reach` of the box around the points `first` to `last`.

    Returns the (3, m) copy, in `near` or in a larger array, and how many they are.
    """
    total = 0
    for k in range(9):
        total += start[runs[k, 1]] - start[runs[k, 0]]
    if total > near.shape[1]:
        near = np.empty((3, 2 * total))
    lx, ly, lz = hx, hy, hz = x[first], y[first], z[first]
    for p in range(first + 1, last):
        lx, ly, lz = min(lx, x[p]), min(ly, y[p]), min(lz, z[p])
        hx, hy, hz = max(hx, x[p]), max(hy, y[p]), max(hz, z[p])
    limit = reach * reach * (1.0 + 1e-9)
    count = 0
    for k in range(9):
        for j in range(start[runs[k, 0]], start[runs[k, 1]]):
            near[0, count], near[1, count], near[2, count] = x[j], y[j], z[j]
            dx = max(lx - x[j], max(x[j] - hx, 0.0))
            dy = max(ly - y[j], max(y[j] - hy, 0.0))
            dz = max(lz - z[j], max(z[j] - hz, 0.0))
            count += dx * dx + dy * dy + dz * dz <= limit
    return near, count


@njit(**INNER)
def _grow_ball(
    near: AnyArray, total: int, px: float, py: float, pz: float, scanner: AnyArray,
    widths: AnyArray, enough: int, sums: AnyArray,
) -> tuple[float, bool]:  # fmt: skip
    """Sum balls of rising width around p until one holds enough.

    Returns the last width tried, and whether its points cover an area.
    """
    radius, defined = 0.0, False
    for radius in widths:
        (
            sums[0], sums[1], sums[2], sums[3], sums[4],
            sums[5], sums[6], sums[7], sums[8], sums[9],
        ) = sum_ball(near, total, px, py, pz, radius * radius)  # fmt: skip
        defined = covers_area(sums, px, py, pz, scanner, radius)
        if sums[0] >= enough and defined:
            break
    return radius, defined


@njit(**INNER)
def _fill_lane(
    lanes: AnyArray, own: AnyArray, slots: AnyArray, k: int, sums: AnyArray, px: float, py: float,
    pz: float, s: int,
) -> int:  # fmt: skip
    """Put a ball's sums, its point and its slot into lane k; counts the one lane."""
    for m in range(SUMS):
        lanes[m * LANES + k] = sums[m]
    own[k], own[LANES + k], own[2 * LANES + k] = px, py, pz
    slots[k] = s
    return 1


@njit(**INNER)
def _store_lanes(
    lanes: AnyArray, own: AnyArray, slots: AnyArray, used: int, scanner: AnyArray,
    planes: AnyArray, sums: AnyArray, normals: AnyArray, rms: AnyArray,
) -> None:  # fmt: skip
    """Solve the planes of the lanes in use, and write them to their slots."""
    solve_lanes(lanes, own, scanner, 0.0, planes)
    for k in range(used):
        s = slots[k]
        if planes[5 * LANES + k] > 0.0:
            for axis in range(3):
                normals[s, axis] = planes[axis * LANES + k]
            rms[s] = planes[3 * LANES + k]
        else:
            for m in range(SUMS):
                sums[m] = lanes[m * LANES + k]
            store_plane(sums, own[k], own[LANES + k], own[2 * LANES + k], scanner, s, normals, rms)


@njit(cache=True, nogil=True, error_model="numpy")
def fit_in_voxels(
    x: AnyArray, y: AnyArray, z: AnyArray, member: AnyArray, keys: AnyArray, start: AnyArray,
    slot: AnyArray, first: int, last: int, scanner: AnyArray, widths: AnyArray, enough: int,
    final: bool, normals: AnyArray, count: AnyArray, width: AnyArray, rms: AnyArray,
) -> None:  # fmt: skip
    """Planes of the points in the voxels `first` to `last`.

    Voxels are sorted, so those around one lie in nine runs of the list, and the ends of the
    runs only move forward from voxel to voxel: no search, no hash table. The points in reach
    are copied once for all points of a voxel. A slot is left undone (width 0) when its ball
    does not hold `enough` points, unless this is the `final` try.
    """
    sums, lanes, planes = np.empty(SUMS), np.zeros(SUMS * LANES), np.empty(PLANES * LANES)
    own, slots, used = np.zeros(3 * LANES), np.empty(LANES, np.int64), 0
    near, total = np.empty((3, 1024)), 0
    runs = np.zeros((9, 2), np.int64)
    for k in range(9):
        runs[k] = np.searchsorted(keys, keys[first] + _offset(k) - 1)
    for v in range(first, last):
        _advance(keys, v, runs)
        loaded = False
        for p in range(start[v], start[v + 1]):
            s = slot[member[p]]
            if s < 0 or width[s] > 0.0:
                continue
            if not loaded:
                near, total = _gather(
                    x, y, z, start, runs, start[v], start[v + 1], widths[-1], near
                )
                loaded = True
            px, py, pz = x[p], y[p], z[p]
            radius, defined = _grow_ball(near, total, px, py, pz, scanner, widths, enough, sums)
            if final or (sums[0] >= enough and defined):
                count[s] = int(sums[0])
                width[s] = radius
                used += _fill_lane(lanes, own, slots, used, sums, px, py, pz, s) if defined else 0
            if used == LANES:
                _store_lanes(lanes, own, slots, used, scanner, planes, sums, normals, rms)
                used = 0
    _store_lanes(lanes, own, slots, used, scanner, planes, sums, normals, rms)
