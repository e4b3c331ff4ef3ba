"""A range image tile by tile: ranges with a halo, which beams follow one another on a surface."""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.record_noise import select

MOST = 12
"""Cells to either side that a beam is looked at over; a wider one is looked at there only."""
BLOCK = 16
"""Cells of a side over which the noise of the range is measured."""
HALO = BLOCK
"""Cells around a tile: a whole block, and more than `MOST` and the cells that links look at."""
SAMPLES = 40
"""Differences that tell the noise of a block; with fewer it is that of the scan."""
STEEP = 4.0
"""Tangent up to which a surface may rise if one side of a step continues in line; both sides
must where it is steeper, since between two surfaces mixed ranges rise in line, too."""
IN_LINE = 1.5
"""Gates that a range may miss the line through the two before it."""


class Scene(NamedTuple):
    """A range image and the beam that made it."""

    inverse: Any  # (rows, columns) 1 / m of the nearest return; 0 without one
    several: Any  # (rows, columns) bool: returns of different ranges
    down: Any  # (rows,) radians to the next row
    turn: Any  # (columns,) radians of azimuth to the next column
    level: Any  # (rows,) cosine of the elevation
    seam: bool
    radius: float  # m, at the aperture
    spread: float  # tan of the half divergence
    rays: Any  # (3, k): offsets in units of the radius, share
    outwards: Any  # (s,) radii from the beam's middle to an edge with a share of 0 … 1 beyond it
    noise: float  # m, of the scan
    gates: float  # σ of the noise that neighbouring ranges may differ by
    least: float  # m, that they may differ by in any case


class Piece(NamedTuple):
    """A tile and its halo; memory for the largest."""

    d: Any  # (n, n) range, m; 0 in holes, -1 outside the grid
    gate: Any  # (blocks, blocks) m
    right: Any  # (n, n) bool: goes on to the next column
    below: Any  # (n, n) bool: goes on to the next row
    solid: Any  # (n, n) bool: part of a surface, 2 × 2 beams at least
    several: Any  # (n, n) bool: returns of different ranges
    rough: Any  # (n + 1, n + 1) integral of what is no plain surface
    label: Any  # (2 MOST + 1, 2 MOST + 1)
    queue: Any  # ((2 MOST + 1)², 2)
    bends: Any  # (2 BLOCK²,)


@njit(**INNER)
def make_piece(tile):  # type: ignore[no-untyped-def]
    """Memory for tiles of so many cells to a side."""
    n, m = tile + 2 * HALO, 2 * MOST + 1
    return Piece(
        np.zeros((n, n)), np.zeros((n // BLOCK, n // BLOCK)), np.zeros((n, n), np.bool_),
        np.zeros((n, n), np.bool_), np.zeros((n, n), np.bool_),
        np.zeros((n, n), np.bool_), np.zeros((n + 1, n + 1), np.int32), np.zeros((m, m), np.int8),
        np.zeros((m * m, 2), np.int64), np.zeros(2 * BLOCK * BLOCK),
    )  # fmt: skip


@njit(**INNER)
def load_piece(scene, place, piece, n):  # type: ignore[no-untyped-def]
    """Copy ranges; tell gates, links and surfaces; n cells to a side."""
    rows, columns = scene.inverse.shape
    inverse, seam = scene.inverse, scene.seam
    d, several, row, column = piece.d, piece.several, place[0] - HALO, place[1] - HALO
    for i in range(n):
        r = row + i
        for j in range(n):
            c = column + j
            if seam:
                c %= columns
            if 0 <= r < rows and 0 <= c < columns:
                w = inverse[r, c]
                d[i, j] = 1.0 / w if w > 0.0 else 0.0
                several[i, j] = scene.several[r, c]
            else:
                d[i, j], several[i, j] = -1.0, False
    for a in range(n // BLOCK):
        for b in range(n // BLOCK):
            noise = measure_block(d, a * BLOCK, b * BLOCK, piece.bends)
            noise = scene.noise if math.isnan(noise) else noise
            piece.gate[a, b] = max(scene.least, scene.gates * noise)
    link(scene, row, column, piece, n)
    mark_surfaces(piece, n)


@njit(**INNER)
def measure_block(d, top, left, bends):  # type: ignore[no-untyped-def]
    """σ of the range in a block, from second differences along rows (robust); NaN: too few."""
    count = 0
    for i in range(top, top + BLOCK):
        for j in range(left + 1, left + BLOCK - 1):
            if d[i, j - 1] > 0.0 and d[i, j] > 0.0 and d[i, j + 1] > 0.0:
                bends[count] = abs(d[i, j - 1] - 2.0 * d[i, j] + d[i, j + 1])
                count += 1
    if count < SAMPLES:
        return math.nan
    return select(bends, count, count // 2) / (0.6745 * math.sqrt(6.0))


@njit(**INNER, forceinline=True)
def goes_on(before, a, b, after, gate, steep):  # type: ignore[no-untyped-def]
    """Whether ranges a and b of neighbouring beams are of one surface; 0: nothing there."""
    if a <= 0.0 or b <= 0.0:
        return False
    step = abs(b - a)
    if step <= gate:
        return True
    ahead = before > 0.0 and abs(2.0 * a - before - b) <= IN_LINE * gate
    back = after > 0.0 and abs(2.0 * b - after - a) <= IN_LINE * gate
    return (ahead or back) if step <= gate + steep else (ahead and back)


@njit(**INNER)
def link(scene, row, column, piece, n):  # type: ignore[no-untyped-def]
    """Tell which neighbouring beams go on along one surface."""
    rows, columns = scene.inverse.shape
    down, turn, level = scene.down, scene.turn, scene.level
    d, gates, right, below = piece.d, piece.gate, piece.right, piece.below
    for i in range(n):
        r = min(max(row + i, 0), rows - 1)
        for j in range(n):
            c = (column + j) % columns
            gate, a = gates[i // BLOCK, j // BLOCK], d[i, j]
            right[i, j] = j + 1 < n and goes_on(
                d[i, j - 1] if j > 0 else 0.0, a, d[i, j + 1], d[i, j + 2] if j + 2 < n else 0.0,
                gate, STEEP * abs(turn[c]) * level[r] * a,
            )  # fmt: skip
            below[i, j] = i + 1 < n and goes_on(
                d[i - 1, j] if i > 0 else 0.0, a, d[i + 1, j], d[i + 2, j] if i + 2 < n else 0.0,
                gate, STEEP * abs(down[r]) * a,
            )  # fmt: skip


@njit(**INNER)
def mark_surfaces(piece, n):  # type: ignore[no-untyped-def]
    """Mark what is part of 2 × 2 linked beams, and add up what is no plain surface."""
    d, right, below, solid, rough = piece.d, piece.right, piece.below, piece.solid, piece.rough
    several = piece.several
    for i in range(n):
        for j in range(n):
            solid[i, j] = False
    for i in range(n - 1):
        for j in range(n - 1):
            if right[i, j] and right[i + 1, j] and below[i, j] and below[i, j + 1]:
                solid[i, j] = solid[i, j + 1] = solid[i + 1, j] = solid[i + 1, j + 1] = True
    for i in range(n):
        line = 0
        for j in range(n):
            plain = d[i, j] < 0.0  # beyond the border of the scan nothing is known
            if d[i, j] > 0.0:
                plain = solid[i, j] and not several[i, j]
                plain = plain and (right[i, j] or j + 1 == n or d[i, j + 1] < 0.0)
                plain = plain and (below[i, j] or i + 1 == n or d[i + 1, j] < 0.0)
            line += not plain
            rough[i + 1, j + 1] = rough[i, j + 1] + line
