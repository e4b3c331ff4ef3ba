"""Connected surfaces on a scan grid: joined cell by cell, cut at necks, looked at from outside."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from app.core.arrays import AnyArray

SLOPE = 3.0
"""Tangent up to which neighbouring beams belong to one surface, 72°."""
SAMPLES = 3
"""Cells looked at on either side of a point; they stand apart where the grid is dense."""
SOLID = 0.6
"""Share of those cells that a solid part fills; a point at a straight edge sees 4 of 7."""
BEHIND = 8
"""Cells that hold nothing but ghosts, behind which a border is still looked for."""
UNKNOWN, NEARER, FARTHER, EMPTY = 0, 1, 2, 3
"""What lies beside a border point; unknown are its own surface and what is outside the grid."""


class Beams(NamedTuple):
    """Points in the order of their cells, (m,) arrays; those of cell k begin at start[k].

    Kernels that meet every point unpack it first: handing it on costs more than their work.
    """

    distance: AnyArray
    usable: AnyArray
    row: AnyArray
    column: AnyArray
    start: AnyArray
    down: AnyArray
    across: AnyArray
    seam: bool
    jump: float


@njit(cache=True, nogil=True)
def find_root(parent: AnyArray, p: int) -> int:
    """Root of p, halving the path on the way."""
    while parent[p] != p:
        parent[p] = parent[parent[p]]
        p = parent[p]
    return p


@njit(cache=True, nogil=True)
def join_cells(beams: Beams, chosen: AnyArray, parent: AnyArray, first: int, last: int) -> None:
    """Join each chosen point with those of the cells to the right, below, and below beside."""
    distance, _, row, column, start, down, across, seam, jump = beams
    rows, columns = across.size, down.size
    for p in range(first, last):
        if not chosen[p]:
            continue
        r, c = row[p], column[p]
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
                if chosen[q] and abs(distance[q] - distance[p]) <= max(jump, SLOPE * reach):
                    a, b = find_root(parent, p), find_root(parent, q)
                    parent[max(a, b)] = min(a, b)


@njit(cache=True, nogil=True)
def number_surfaces(parent: AnyArray, chosen: AnyArray, label: AnyArray) -> None:
    """Label chosen points 0, 1, … by root; a root is the first point of its surface."""
    count = 0
    for p in range(parent.size):
        if chosen[p]:
            root = find_root(parent, p)
            if root == p:
                label[p] = count
                count += 1
            else:
                label[p] = label[root]


@njit(cache=True, nogil=True)
def measure_boxes(
    x: AnyArray, y: AnyArray, z: AnyArray, label: AnyArray, low: AnyArray, high: AnyArray
) -> None:
    """Widen the box of each label, low and high (labels, 3), to hold its points."""
    for p in range(label.size):
        k = label[p]
        if k >= 0:
            low[k, 0], high[k, 0] = min(low[k, 0], x[p]), max(high[k, 0], x[p])
            low[k, 1], high[k, 1] = min(low[k, 1], y[p]), max(high[k, 1], y[p])
            low[k, 2], high[k, 2] = min(low[k, 2], z[p]), max(high[k, 2], z[p])


@njit(cache=True, nogil=True)
def spread_samples(reach: float, cell: float, total: int) -> tuple[int, int]:
    """Samples on either side, and cells from one to the next, so that they span `reach`."""
    cells = min(max(reach / cell, 1.0), total // 3)
    count = min(SAMPLES, int(cells))
    return count, int(cells / max(count, 1) + 0.5)


@njit(cache=True, nogil=True)
def mark_solid(beams: Beams, reach: float, solid: AnyArray, first: int, last: int) -> None:
    """Mark points whose surface fills most of the window that spans `reach` metres around."""
    distance, usable, row, column, start, down, across, seam, jump = beams
    rows, columns = across.size, down.size
    for p in range(first, last):
        if not usable[p]:
            continue
        r, c, away = np.int64(row[p]), np.int64(column[p]), distance[p]
        tall, wide = down[c] * away, across[r] * away
        high, row_step = spread_samples(reach, tall, rows)
        side, column_step = spread_samples(reach, wide, columns)
        inside = filled = 0
        for i in range(-high * row_step, high * row_step + 1, max(row_step, 1)):
            if not 0 <= r + i < rows:
                continue
            for j in range(-side * column_step, side * column_step + 1, max(column_step, 1)):
                c1 = c + j
                if seam:
                    c1 += columns * (int(c1 < 0) - int(c1 >= columns))
                if not 0 <= c1 < columns:
                    continue
                inside += 1
                cell = (r + i) * columns + c1
                most = max(jump, SLOPE * math.sqrt((i * tall) ** 2 + (j * wide) ** 2))
                for q in range(start[cell], start[cell + 1]):
                    if usable[q] and abs(distance[q] - away) <= most:
                        filled += 1
                        break
        solid[p] = filled > SOLID * inside


@njit(cache=True, nogil=True)
def find_cell(beams: Beams, p: int, dr: int, dc: int) -> int:
    """Cell dr rows below and dc columns to the right of point p; -1 outside the grid."""
    columns = beams.down.size
    r, c = np.int64(beams.row[p]) + dr, np.int64(beams.column[p]) + dc
    if beams.seam:
        c = c % columns
    if r < 0 or r >= beams.across.size or c < 0 or c >= columns:
        return -1
    return int(r * columns + c)


@njit(cache=True, nogil=True)
def measure_gap(beams: Beams, p: int, dr: int, dc: int) -> float:
    """Metres across the beams from p to that cell, at the range of p."""
    down, across = beams.down[beams.column[p]], beams.across[beams.row[p]]
    return float(math.hypot(dr * down, dc * across) * beams.distance[p])


@njit(cache=True, nogil=True)
def find_giver(beams: Beams, p: int, away: AnyArray, reach: float) -> tuple[int, float]:
    """The point beside p, on its surface, that is nearest to a solid part, and how near p is."""
    best, nearest = -1, math.inf
    for k in range(9):
        dr, dc = k // 3 - 1, k % 3 - 1
        cell = find_cell(beams, p, dr, dc)
        if cell < 0:
            continue
        gap = measure_gap(beams, p, dr, dc)
        for q in range(beams.start[cell], beams.start[cell + 1]):
            step = abs(beams.distance[q] - beams.distance[p])
            joined = step <= max(beams.jump, SLOPE * gap)
            if joined and away[q] < reach and away[q] + gap < nearest:
                best, nearest = int(q), away[q] + gap
    return best, nearest


@njit(cache=True, nogil=True)
def grow_rims(beams: Beams, label: AnyArray, reach: float) -> None:
    """Give unlabelled points the label of the surface beside, in rounds, up to `reach` metres."""
    away = np.where(label >= 0, 0.0, np.inf)
    todo = np.flatnonzero(beams.usable & (label < 0))
    giver, nearest = np.empty(todo.size, np.int64), np.empty(todo.size)
    while todo.size:
        for k in range(todo.size):
            giver[k], nearest[k] = find_giver(beams, todo[k], away, reach)
        given = giver[: todo.size] >= 0
        if not given.any():
            break
        for found in np.flatnonzero(given):
            away[todo[found]] = nearest[found]
            label[todo[found]] = label[giver[found]]
        todo = todo[~given]


@njit(cache=True, nogil=True)
def look_beside(beams: Beams, label: AnyArray, p: int, dr: int, dc: int) -> int:
    """What lies beside p in a direction, behind the ghosts."""
    for k in range(1, BEHIND + 1):
        cell = find_cell(beams, p, k * dr, k * dc)
        if cell < 0:
            return UNKNOWN
        if beams.start[cell] == beams.start[cell + 1]:
            return EMPTY
        most = max(beams.jump, SLOPE * measure_gap(beams, p, k * dr, k * dc))
        seen = UNKNOWN
        for q in range(beams.start[cell], beams.start[cell + 1]):
            if beams.usable[q]:
                step = beams.distance[q] - beams.distance[p]
                if abs(step) <= most or label[q] == label[p]:
                    return UNKNOWN
                seen = NEARER if step < 0.0 or seen == NEARER else FARTHER
        if seen != UNKNOWN:
            return seen
    return UNKNOWN


@njit(cache=True, nogil=True)
def list_meetings(beams: Beams, label: AnyArray, meeting: AnyArray) -> int:
    """Pairs of labels that meet along a row or column, behind ghosts and what is nearer.

    `meeting` is (k, 2); how many were found comes back, and no more than k are written.
    """
    count = 0
    for p in range(label.size):
        if label[p] < 0:
            continue
        for k in range(2):
            other = look_across(beams, label, p, 1 - k, k)
            if other >= 0:
                if count < meeting.shape[0]:
                    meeting[count, 0], meeting[count, 1] = label[p], other
                count += 1
    return count


@njit(cache=True, nogil=True)
def look_across(beams: Beams, label: AnyArray, p: int, dr: int, dc: int) -> int:
    """Another label at about the same range, the first beyond p's own; -1: none."""
    for k in range(1, BEHIND + 1):
        cell = find_cell(beams, p, k * dr, k * dc)
        if cell < 0 or beams.start[cell] == beams.start[cell + 1]:
            return -1
        most = max(beams.jump, SLOPE * measure_gap(beams, p, k * dr, k * dc))
        for q in range(beams.start[cell], beams.start[cell + 1]):
            step = beams.distance[q] - beams.distance[p]
            if label[q] == label[p]:
                return -1
            if label[q] >= 0 and abs(step) <= most:
                return int(label[q])
            if beams.usable[q] and step > most:
                return -1
    return -1


@njit(cache=True, nogil=True)
def count_borders(beams: Beams, label: AnyArray, border: AnyArray) -> None:
    """Count what lies beside the points of each label, (labels, 4)."""
    _, _, row, column, start, down, across, _, _ = beams
    columns = down.size
    for p in range(label.size):
        if label[p] < 0:
            continue
        for k in range(4):
            dr, dc = (k - 1, 0) if k % 2 == 0 else (0, k - 2)
            r, c = np.int64(row[p]) + dr, np.int64(column[p]) + dc
            if 0 <= r < across.size and 0 <= c < columns:
                q = start[r * columns + c]
                if q < start[r * columns + c + 1] and label[q] == label[p]:
                    continue  # inside the surface, as most are: spares the costly look
            border[label[p], look_beside(beams, label, p, dr, dc)] += 1
