"""Directions of points, and the rows and columns that they lie on."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray
from app.core.kernels import INNER, SAFE

TURN = 2.0 * math.pi
BINS = 64
PATCH = 32
SHIFT = 5
"""PATCH is 2 ** SHIFT: dividing whole numbers is slow."""
BATCH = 512
ROOM = 1 << 17
FAR = 0.35
FARTHEST = 32
STEEP = 1.3
"""Elevation, radians, beyond which columns are too close to be judged by."""


@njit(cache=True, nogil=True, error_model="numpy")
def sample_directions(xyz: AnyArray, scanner: AnyArray, stride: int) -> AnyArray:
    """Azimuth, elevation and range, (3, m), of one point out of every `stride`.

    Which one changes from stride to stride: a fixed one may fall on every tenth row only.
    """
    beams = np.empty((3, len(xyz) // stride))
    total = 0
    state = np.uint64(1)
    for k in range(len(xyz) // stride):
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        i = k * stride + np.int64((state >> np.uint64(33)) % np.uint64(stride))
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        square = dx * dx + dy * dy + dz * dz
        if 0.0 < square < math.inf:
            beams[0, total] = math.atan2(dy, dx)
            beams[1, total] = math.atan2(dz, math.sqrt(dx * dx + dy * dy))
            beams[2, total] = math.sqrt(square)
            total += 1
    return beams[:, :total].copy()


@njit(**INNER)
def _angle(y: float, x: float) -> float:
    """Angle of (x, y) to 2e-8 radians, without branches (Abramowitz and Stegun 1964, 4.4.49)."""
    across, along = abs(y), abs(x)
    large = max(across, along)
    t = min(across, along) / (large if large > 0.0 else 1.0)
    s = t * t
    p = -0.0161657367 + s * 0.0028662257
    p = 0.0429096138 + s * p
    p = -0.0752896400 + s * p
    p = 0.1065626393 + s * p
    p = -0.1420889944 + s * p
    p = 0.1999355085 + s * p
    p = -0.3333314528 + s * p
    angle = t + t * s * p
    angle = 0.5 * math.pi - angle if across > along else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SAFE)
def look(
    xyz: AnyArray, scanner: AnyArray, axes: AnyArray, lattice: AnyArray, seen: AnyArray
) -> None:
    """Row and column as real numbers, elevation, and whether there is a range, into (4, n).

    `lattice` holds cut, rows per elevation, rows per turn, first row, columns per turn,
    columns per elevation, first column.
    """
    sx, sy, sz = scanner[0], scanner[1], scanner[2]
    ux, uy, uz = axes[0, 0], axes[0, 1], axes[0, 2]
    vx, vy, vz = axes[1, 0], axes[1, 1], axes[1, 2]
    wx, wy, wz = axes[2, 0], axes[2, 1], axes[2, 2]
    cut, r1, r2, r0 = lattice[0], lattice[1], lattice[2], lattice[3]
    c1, c2, c0 = lattice[4], lattice[5], lattice[6]
    for i in range(xyz.shape[0]):
        dx, dy, dz = xyz[i, 0] - sx, xyz[i, 1] - sy, xyz[i, 2] - sz
        square = dx * dx + dy * dy + dz * dz
        u = ux * dx + uy * dy + uz * dz
        v = vx * dx + vy * dy + vz * dz
        w = wx * dx + wy * dy + wz * dz
        elevation = _angle(w, math.sqrt(u * u + v * v))
        turn = cut - _angle(v, u)
        turn -= TURN * np.floor(turn / TURN)
        seen[0, i] = r1 * elevation + r2 * turn + r0
        seen[1, i] = c1 * turn + c2 * elevation + c0
        seen[2, i] = elevation
        seen[3, i] = 1.0 if 0.0 < square < math.inf else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def sum_phases(seen: AnyArray, down: AnyArray, across: AnyArray) -> None:
    """Add up what rows (cosine, sine, count) and columns (cosine, sine) lack, patch by patch."""
    for i in range(seen.shape[1]):
        row, column = seen[0, i], seen[1, i]
        p = min(max(int(row / PATCH), 0), down.shape[0] - 1)
        q = min(max(int(column / PATCH), 0), down.shape[1] - 1)
        down[p, q, 0] += math.cos(TURN * row)
        down[p, q, 1] += math.sin(TURN * row)
        down[p, q, 2] += 1.0
        across[p, q, 0] += math.cos(TURN * column)
        across[p, q, 1] += math.sin(TURN * column)


@njit(**INNER)
def _join_around(
    p: int, q: int, known: AnyArray, done: AnyArray, shift: AnyArray, queue: AnyArray, tail: int
) -> int:
    rows, columns = known.shape
    for i in range(max(p - 1, 0), min(p + 2, rows)):
        for j in range(max(q - 1, 0), min(q + 2, columns)):
            if known[i, j] and not done[i, j]:
                for k in range(2):
                    shift[i, j, k] += round(shift[p, q, k] - shift[i, j, k])
                done[i, j] = True
                queue[tail, 0], queue[tail, 1] = i, j
                tail += 1
    return tail


@njit(**INNER)
def _find_done(p: int, q: int, done: AnyArray) -> tuple[int, int]:
    """The nearest patch that is done, within `FARTHEST`; the patch itself where there is none."""
    rows, columns = done.shape
    best, near = (FARTHEST + 1) ** 2, (p, q)
    for i in range(max(p - FARTHEST, 0), min(p + FARTHEST + 1, rows)):
        for j in range(max(q - FARTHEST, 0), min(q + FARTHEST + 1, columns)):
            away = (i - p) ** 2 + (j - q) ** 2
            if done[i, j] and away < best:
                best, near = away, (i, j)
    return near


@njit(cache=True, nogil=True, error_model="numpy")
def follow_phases(order: AnyArray, known: AnyArray, shift: AnyArray) -> None:
    """Make the shifts (rows, columns, 2) of patches continuous, from neighbour to neighbour.

    `order` lists the patches to start from, best first; `known` marks those with a phase. A
    start beside nothing follows the nearest patch that is done.
    """
    rows, columns = known.shape
    done = np.zeros((rows, columns), np.bool_)
    queue = np.empty((order.size, 2), np.int64)
    for start in order:
        p0, q0 = start // columns, start % columns
        if done[p0, q0]:
            continue
        p, q = _find_done(p0, q0, done)
        for k in range(2):
            shift[p0, q0, k] += round(shift[p, q, k] - shift[p0, q0, k])
        done[p0, q0] = True
        queue[0, 0], queue[0, 1] = p0, q0
        head, tail = 0, 1
        while head < tail:
            tail = _join_around(queue[head, 0], queue[head, 1], known, done, shift, queue, tail)
            head += 1


@njit(**INNER)
def _round_batch(
    seen: AnyArray, size: int, shift: AnyArray, row: AnyArray, column: AnyArray,
    counts: AnyArray, ends: AnyArray,
) -> None:  # fmt: skip
    rows, columns = shift.shape[0], shift.shape[1]
    for i in range(size):
        if seen[3, i] == 0.0:
            row[i], column[i] = -1, -1
            continue
        r, c = seen[0, i], seen[1, i]
        y = min(max(r / PATCH - 0.5, 0.0), rows - 1.0)
        x = min(max(c / PATCH - 0.5, 0.0), columns - 1.0)
        p, q = min(int(y), rows - 2), min(int(x), columns - 2)
        y -= p
        x -= q
        a, b, d, e = (1.0 - y) * (1.0 - x), (1.0 - y) * x, y * (1.0 - x), y * x
        r -= (
            a * shift[p, q, 0] + b * shift[p, q + 1, 0]
            + d * shift[p + 1, q, 0] + e * shift[p + 1, q + 1, 0]
        )  # fmt: skip
        c -= (
            a * shift[p, q, 1] + b * shift[p, q + 1, 1]
            + d * shift[p + 1, q, 1] + e * shift[p + 1, q + 1, 1]
        )  # fmt: skip
        whole_r, whole_c = max(np.floor(r + 0.5), 0.0), max(np.floor(c + 0.5), 0.0)
        row[i], column[i] = np.int32(whole_r), np.int32(whole_c)
        ends[0], ends[1] = min(ends[0], row[i]), max(ends[1], row[i])
        ends[2], ends[3] = min(ends[2], column[i]), max(ends[3], column[i])
        if abs(seen[2, i]) < STEEP:
            off_r, off_c = abs(r - whole_r), abs(c - whole_c)
            counts[0, min(int(off_r * 2 * BINS), BINS - 1)] += 1
            counts[1, min(int(off_c * 2 * BINS), BINS - 1)] += 1
            counts[2, 0] += 1
            counts[2, 1] += off_r > FAR or off_c > FAR


@njit(cache=True, nogil=True, error_model="numpy")
def place_points(
    xyz: AnyArray, scanner: AnyArray, axes: AnyArray, lattice: AnyArray, shift: AnyArray,
    first: int, last: int, row: AnyArray, column: AnyArray, counts: AnyArray, ends: AnyArray,
) -> None:  # fmt: skip
    """Round the points `first` to `last` to rows and columns, interpolating the shifts.

    `counts` (3, BINS) gets how far they lie from their row, from their column (half a step is
    the last bin), and [points, far ones]; `ends` the first and last row and column. Points
    without a range get row -1.
    """
    seen = np.empty((4, BATCH))
    for start in range(first, last, BATCH):
        stop = min(start + BATCH, last)
        look(xyz[start:stop], scanner, axes, lattice, seen)
        _round_batch(seen, stop - start, shift, row[start:stop], column[start:stop], counts, ends)


@njit(cache=True, nogil=True, error_model="numpy")
def start_rows(row: AnyArray, column: AnyArray, first_row: int, first_column: int) -> None:
    """Count rows and columns from 0; points without a range come into the first cell."""
    for i in range(row.size):
        lost = row[i] < 0
        row[i] = 0 if lost else row[i] - first_row
        column[i] = 0 if lost else column[i] - first_column


@njit(cache=True, nogil=True, error_model="numpy")
def gather_blocks(
    xyz: AnyArray, scanner: AnyArray, row: AnyArray, column: AnyArray, slot: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """Cell within the chosen blocks, and range, of each usable point that lies in one."""
    found = np.empty(ROOM, np.int64)
    total = 0
    for i in range(row.size):
        if slot[row[i] >> SHIFT, column[i] >> SHIFT] >= 0:
            if total == found.size:
                found = np.append(found, np.empty_like(found))
            found[total] = i
            total += 1
    cell, distance = np.empty(total, np.int64), np.empty(total)
    kept = 0
    for i in found[:total]:
        block = np.int64(slot[row[i] >> SHIFT, column[i] >> SHIFT])
        dx, dy, dz = xyz[i, 0] - scanner[0], xyz[i, 1] - scanner[1], xyz[i, 2] - scanner[2]
        square = dx * dx + dy * dy + dz * dz
        if 0.0 < square < math.inf:
            cell[kept] = (block * PATCH + row[i] % PATCH) * PATCH + column[i] % PATCH
            distance[kept] = math.sqrt(square)
            kept += 1
    return cell[:kept].copy(), distance[:kept].copy()
