"""Support of a point by the beams around it, and the surface that dominates a ghost."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.core.arrays import AnyArray

STEEPEST = 4.0
"""Tangent of the steepest surface that lends support, 76°."""
SLOPE = 0.5
ALONE = 12
"""With fewer beams than this around it, a point is as good as beside a jump."""


@njit(cache=True, nogil=True)
def _is_supported(own: float, reach: float, gate: float, near: AnyArray, far: AnyArray) -> bool:
    """Whether a return of the near cell continues the surface of `own`, alone or in line with
    one of the far cell, twice as far away.
    """
    for a in near:
        jump = abs(a - own)
        if jump <= gate + SLOPE * reach:
            return True
        if jump <= gate + STEEPEST * reach:
            for b in far:
                if abs(2.0 * a - b - own) <= gate:
                    return True
    return False


@njit(cache=True, nogil=True)
def _look_aside(
    distance: AnyArray, member: AnyArray, start: AnyArray, r: int, c: int, dr: int, dc: int,
    own: float, down: AnyArray, across: AnyArray, seam: bool, intensity: AnyArray, gate: float,
) -> tuple[bool, float, float]:  # fmt: skip
    """What the beam (dr, dc) away says: support, the jump beyond any slope, its intensity.

    The jump is negative where there is no such beam.
    """
    rows, columns = across.size, down.size
    r1, c1, r2, c2 = r + dr, c + dc, r + 2 * dr, c + 2 * dc
    if seam:
        c1, c2 = c1 % columns, c2 % columns
    if (dr == 0 and dc == 0) or not (0 <= r1 < rows and 0 <= c1 < columns):
        return False, -1.0, math.nan
    cell = np.int64(r1) * columns + c1
    near = distance[start[cell] : start[cell + 1]]
    if near.size == 0:
        return False, -1.0, math.nan
    far = near[:0]
    if 0 <= r2 < rows and 0 <= c2 < columns:
        cell2 = np.int64(r2) * columns + c2
        far = distance[start[cell2] : start[cell2 + 1]]
    reach = own * math.hypot(dr * down[c], dc * across[r])
    value = intensity[member[start[cell]]] if intensity.size else math.nan
    off = max(0.0, abs(near[0] - own) - STEEPEST * reach)
    return _is_supported(own, reach, gate, near, far), off, value


@njit(cache=True, nogil=True)
def score_support(
    distance: AnyArray, member: AnyArray, start: AnyArray, row: AnyArray, column: AnyArray,
    slot: AnyArray, first: int, last: int, down: AnyArray, across: AnyArray, seam: bool,
    intensity: AnyArray, half: int, gate: float, jump: float, score: AnyArray, share: AnyArray,
) -> None:  # fmt: skip
    """Score the sorted points `first` to `last` that have a slot: 1 − the share of supporters.

    Zero where no neighbour stands off by more than `jump` beyond the steepest slope: a steep
    part inside a leaf is no ghost. `share` gets intensity over the mean of the neighbours'.
    """
    window = (2 * half + 1) ** 2 - 1
    for p in range(first, last):
        i = member[p]
        k = slot[i]
        if k < 0:
            continue
        beams, supporters, light, lights, beside_jump = 0, 0, 0.0, 0, False
        for step in range((2 * half + 1) ** 2):
            dr, dc = step // (2 * half + 1) - half, step % (2 * half + 1) - half
            supported, off, value = _look_aside(
                distance, member, start, row[i], column[i], dr, dc, distance[p],
                down, across, seam, intensity, gate,
            )  # fmt: skip
            if off < 0.0:
                continue
            beams += 1
            supporters += supported
            beside_jump |= off > jump
            if math.isfinite(value):
                light += value
                lights += 1
        # Half of the missing beams count as silent: two specks against the sky that support
        # each other are not a surface.
        score[k] = 1.0 - 2.0 * supporters / (beams + window)
        if beams >= ALONE and not beside_jump:
            score[k] = 0.0
        if lights and light > 0.0:
            share[k] = intensity[i] * lights / light


@njit(cache=True, nogil=True)
def collect_windows(
    member: AnyArray, start: AnyArray, row: AnyArray, column: AnyArray, points: AnyArray,
    rows: int, columns: int, seam: bool, half: int, usable: AnyArray,
) -> tuple[AnyArray, AnyArray]:  # fmt: skip
    """Usable points in the window around each asked point: list borders, and the list."""
    borders = np.zeros(points.size + 1, np.int64)
    found = np.empty(points.size * (2 * half + 1) ** 2, np.int64)
    total = 0
    for k in range(points.size):
        r, c = row[points[k]], column[points[k]]
        for r1 in range(max(r - half, 0), min(r + half, rows - 1) + 1):
            for c1 in range(c - half, c + half + 1):
                if not seam and not 0 <= c1 < columns:
                    continue
                cell = np.int64(r1) * columns + c1 % columns
                for p in range(start[cell], start[cell + 1]):
                    if usable[member[p]] and total < found.size:
                        found[total] = member[p]
                        total += 1
        borders[k + 1] = total
    return borders, found[:total]


@njit(cache=True, nogil=True)
def drop_touched(
    member: AnyArray, start: AnyArray, row: AnyArray, column: AnyArray, ghosts: AnyArray, rows: int,
    columns: int, seam: bool, usable: AnyArray,
) -> None:  # fmt: skip
    """Make the points in cells around a ghost unusable: their beams touch the border too."""
    for i in ghosts:
        r, c = row[i], column[i]
        for r1 in range(max(r - 1, 0), min(r + 1, rows - 1) + 1):
            for c1 in range(c - 1, c + 2):
                if seam or 0 <= c1 < columns:
                    cell = np.int64(r1) * columns + c1 % columns
                    for p in range(start[cell], start[cell + 1]):
                        usable[member[p]] = False


@njit(cache=True, nogil=True)
def _range_on_surface(depth: AnyArray, a: AnyArray, b: AnyArray, weight: AnyArray) -> float:
    """Range at offset 0 of the plane through (a, b, depth); the weighted mean where it fails."""
    n = sa = sb = sd = aa = ab = bb = ad = bd = 0.0
    for k in range(depth.size):
        w, d = weight[k], depth[k] - depth[0]
        n += w
        sa += w * a[k]
        sb += w * b[k]
        sd += w * d
        aa += w * a[k] * a[k]
        ab += w * a[k] * b[k]
        bb += w * b[k] * b[k]
        ad += w * a[k] * d
        bd += w * b[k] * d
    aa, ab, bb = aa - sa * sa / n, ab - sa * sb / n, bb - sb * sb / n
    ad, bd = ad - sa * sd / n, bd - sb * sd / n
    mean = sd / n
    low, high = depth.min() - depth[0], depth.max() - depth[0]
    det = aa * bb - ab * ab
    if det > 0.05 * aa * bb:
        slope_a, slope_b = (ad * bb - bd * ab) / det, (bd * aa - ad * ab) / det
        fitted = mean - (slope_a * sa + slope_b * sb) / n
        # A line drawn out of a few points may run away: not beyond half of their spread.
        spare = 0.5 * (high - low)
        if low - spare <= fitted <= high + spare:
            return float(depth[0] + fitted)
    return float(depth[0] + mean)


@njit(cache=True, nogil=True)
def dominant_ranges(
    xyz: AnyArray, scanner: AnyArray, ghosts: AnyArray, borders: AnyArray, found: AnyArray,
    gap: float, least: int,
) -> AnyArray:  # fmt: skip
    """Range, along the beam of each ghost, of the surface that dominates it; NaN without one.

    Neighbours are cut into surfaces where their sorted ranges leave a gap. The surface with
    most energy draws the mixed range to itself: it is the nearest in range. In the fit, nearer
    beams weigh more.
    """
    result = np.full(ghosts.size, math.nan)
    for g in range(ghosts.size):
        size = borders[g + 1] - borders[g]
        if size < least:
            continue
        own = xyz[ghosts[g]] - scanner
        reported = np.sqrt((own * own).sum())
        beam = own / reported
        axis = np.zeros(3)
        axis[np.argmin(np.abs(beam))] = 1.0
        u = np.cross(beam, axis)
        u = u / np.sqrt((u * u).sum())
        v = np.cross(beam, u)
        depth, a, b, w = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
        widest = 0.0
        for k in range(size):
            d = xyz[found[borders[g] + k]] - scanner
            depth[k] = np.sqrt((d * d).sum())
            a[k], b[k] = (d * u).sum() / depth[k], (d * v).sum() / depth[k]
            w[k] = a[k] * a[k] + b[k] * b[k]
            widest = max(widest, w[k])
        w = np.exp(-6.0 * w / max(widest, 1e-30))
        order = np.argsort(depth)
        depth, a, b, w = depth[order], a[order], b[order], w[order]
        begin, best, first, last = 0, math.inf, 0, 0
        for k in range(1, size + 1):
            if k == size or depth[k] - depth[k - 1] > gap:
                off = max(depth[begin] - reported, reported - depth[k - 1], 0.0)
                if off < best and k - begin >= least:
                    best, first, last = off, begin, k
                begin = k
        if last > first:
            result[g] = _range_on_surface(
                depth[first:last], a[first:last], b[first:last], w[first:last]
            )
    return result
