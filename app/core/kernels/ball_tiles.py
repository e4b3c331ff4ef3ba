"""Planes in balls, on a scan grid: a tile at a time, sixteen cells of a row at once.

A tile is a dense copy of a part of the range image with a margin around it. Where a cell is
empty its point lies far away, so that no loop asks whether there is one. The neighbour so many
rows down and columns across is then, for sixteen cells in a row, sixteen numbers in a row.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER, SAFE
from app.core.kernels.grid import half_window
from app.core.kernels.plane import (
    LANES,
    PLANES,
    SUMS,
    covers_area,
    pick,
    solve_lanes,
    store_plane,
)

TILE = 96
HALO = 16
SIDE = TILE + 2 * HALO
LAYER = 3 * SIDE * SIDE
LAYERS = 4
"""Points of one cell that a tile can hold; where there are more, points are fitted singly."""
MOST_PER_ROW = 512
FAR = 1e18
_U = np.uint64  # An unsigned index cannot be negative: no test for it breaks the wide loop.
_PLANE = _U(SIDE * SIDE)


class Scan(NamedTuple):
    """Points, cell by cell, and the beams that met them."""

    xyz: Any  # (n, 3) metres
    head: Any  # (rows · columns,) number of a cell's first point; -1: none
    after: Any  # (n,) number of the next point in the same cell; -1: none
    slot: Any  # (n,) where its result goes; -1: not asked for
    scanner: Any  # (3,) metres
    down: Any  # (columns,) radians from row to row
    across: Any  # (rows,) radians from column to column
    seam: bool  # the last column lies beside the first


class Rules(NamedTuple):
    """How balls grow."""

    widths: Any  # (w,) metres, rising
    enough: int  # points that a ball must hold
    cells: int  # largest window


class Found(NamedTuple):
    """Results by slot."""

    normals: Any  # (k, 3)
    count: Any  # (k,)
    width: Any  # (k,) metres
    rms: Any  # (k,) metres


class Room(NamedTuple):
    """A tile, and what is worked out on the way."""

    tile: Any  # (LAYERS · LAYER,) x of all cells of a layer, then y, then z
    who: Any  # (LAYERS · SIDE²,) number of the point; -1: none
    own: Any  # (3 · LANES,)
    lanes: Any  # (SUMS · LANES,)
    planes: Any  # (PLANES · LANES,)
    sums: Any  # (SUMS,)


@njit(cache=True, nogil=True)
def chain_cells(row, column, first, last, columns, head, after):  # type: ignore[no-untyped-def]
    """Note the points of the rows `first` to `last`, cell by cell.

    `head` gives a cell's first point, `after` the next one in the same cell; -1: none.
    """
    for k in range(first * columns, last * columns):
        head[k] = -1
    for i in range(row.size - 1, -1, -1):
        if first <= row[i] < last:
            cell = np.int64(row[i]) * columns + column[i]
            after[i] = head[cell]
            head[cell] = i


@njit(**INNER)
def load_tile(scan, top, left, tile, who):  # type: ignore[no-untyped-def]
    """Fill the tile whose first cell is (top, left). Returns its layers; 0: too many."""
    xyz, head, after, scanner, seam = scan.xyz, scan.head, scan.after, scan.scanner, scan.seam
    rows, columns = scan.across.size, scan.down.size
    used = 1
    plane = SIDE * SIDE
    for i in range(SIDE):
        r = top + i
        for j in range(SIDE):
            c = left + j
            if seam:
                c = (c + columns) % columns
            at = i * SIDE + j
            layer = 0
            p = head[r * columns + c] if 0 <= r < rows and 0 <= c < columns else -1
            while p >= 0:
                x, y, z = xyz[p, 0], xyz[p, 1], xyz[p, 2]
                dx, dy, dz = x - scanner[0], y - scanner[1], z - scanner[2]
                if 0.0 < dx * dx + dy * dy + dz * dz < math.inf:
                    if layer == LAYERS:
                        return 0
                    while used <= layer:
                        tile[used * LAYER : (used + 1) * LAYER] = FAR
                        who[used * plane : (used + 1) * plane] = -1
                        used += 1
                    put = layer * LAYER + at
                    tile[put], tile[put + plane], tile[put + 2 * plane] = x, y, z
                    who[layer * plane + at] = p
                    layer += 1
                p = after[p]
            if layer == 0:
                tile[at] = tile[at + plane] = tile[at + 2 * plane] = FAR
                who[at] = -1
    return used


@njit(**INNER, fastmath=SAFE, forceinline=True)
def add_cells(tile, a, b, c, own, limit, sums, k):  # type: ignore[no-untyped-def]
    """Add to the sums of lane k what lies in its ball out of three cells of a tile.

    Three at a time: the sums are loaded and stored a third as often.
    """
    x, y, z = own[k], own[_U(LANES) + k], own[_U(2 * LANES) + k]
    an, ax, ay, az = pick(x, y, z, tile[a], tile[a + _PLANE], tile[a + _PLANE + _PLANE], limit)
    bn, bx, by, bz = pick(x, y, z, tile[b], tile[b + _PLANE], tile[b + _PLANE + _PLANE], limit)
    cn, cx, cy, cz = pick(x, y, z, tile[c], tile[c + _PLANE], tile[c + _PLANE + _PLANE], limit)
    sums[k] += an + bn + cn
    sums[_U(LANES) + k] += ax + bx + cx
    sums[_U(2 * LANES) + k] += ay + by + cy
    sums[_U(3 * LANES) + k] += az + bz + cz
    sums[_U(4 * LANES) + k] += ax * ax + bx * bx + cx * cx
    sums[_U(5 * LANES) + k] += ax * ay + bx * by + cx * cy
    sums[_U(6 * LANES) + k] += ax * az + bx * bz + cx * cz
    sums[_U(7 * LANES) + k] += ay * ay + by * by + cy * cy
    sums[_U(8 * LANES) + k] += ay * az + by * bz + cy * cz
    sums[_U(9 * LANES) + k] += az * az + bz * bz + cz * cz


@njit(**INNER, fastmath=SAFE)
def sum_lanes(tile, first, layers, high, wide, limit, own, sums):  # type: ignore[no-untyped-def]
    """Sums of the balls around `LANES` points in a row of a tile, the first one at `first`."""
    for lane in range(3 * LANES):
        own[lane] = tile[first + (lane // LANES) * SIDE * SIDE + lane % LANES]
    for lane in range(SUMS * LANES):
        sums[lane] = 0.0
    for at in range(layers * (2 * high + 1)):
        line = first % LAYER + LAYER * (at % layers) + SIDE * (at // layers - high)
        for side in range(-wide, wide + 1, 3):
            a = _U(line + side)
            for lane in range(LANES):
                k = _U(lane)
                add_cells(tile, a + k, a + _U(1) + k, a + _U(2) + k, own, limit, sums, k)


@njit(**INNER, fastmath=SAFE)
def sum_around(tile, first, layers, high, limit, own, lanes, sums):  # type: ignore[no-untyped-def]
    """Sums of the ball around one point, over rows of two times `LANES` cells of a tile."""
    for lane in range(3 * LANES):
        own[lane] = tile[first + (lane // LANES) * SIDE * SIDE]
    for lane in range(SUMS * LANES):
        lanes[lane] = 0.0
    for layer in range(layers):
        corner = first % LAYER + LAYER * layer - SIDE * high - LANES
        for part in range(0, 2 * (2 * high + 1), 3):
            a = _U(corner + part // 2 * SIDE + part % 2 * LANES)
            b = _U(corner + (part + 1) // 2 * SIDE + (part + 1) % 2 * LANES)
            c = _U(corner + (part + 2) // 2 * SIDE + (part + 2) % 2 * LANES)
            for lane in range(LANES):
                k = _U(lane)
                add_cells(tile, a + k, b + k, c + k, own, limit, lanes, k)
    for m in range(SUMS):
        sums[m] = 0.0
        for lane in range(LANES):
            sums[m] += lanes[m * LANES + lane]


@njit(**INNER)
def sum_cells(scan, r, c, high, wide, p, limit, sums):  # type: ignore[no-untyped-def]
    """Sums of the ball around point p, cell by cell over a window of any size."""
    xyz, head, after, seam = scan.xyz, scan.head, scan.after, scan.seam
    rows, columns = scan.across.size, scan.down.size
    px, py, pz = xyz[p, 0], xyz[p, 1], xyz[p, 2]
    step = max(1, (2 * wide + 1) // MOST_PER_ROW)
    left, right = c - wide, c + wide + 1
    if right - left >= columns:
        left, right = 0, columns
    if not seam:
        left, right = max(left, 0), min(right, columns)
    n = sx = sy = sz = xx = xy = xz = yy = yz = zz = 0.0
    for line in range(max(r - high, 0), min(r + high, rows - 1) + 1):
        for side in range(left, right, step):
            q = head[line * columns + (side + columns) % columns]
            while q >= 0:
                near, dx, dy, dz = pick(px, py, pz, xyz[q, 0], xyz[q, 1], xyz[q, 2], limit)
                if near > 0.0:
                    n += near
                    sx, sy, sz = sx + dx, sy + dy, sz + dz
                    xx, xy, xz = xx + dx * dx, xy + dx * dy, xz + dx * dz
                    yy, yz, zz = yy + dy * dy, yz + dy * dz, zz + dz * dz
                q = after[q]
    sums[0], sums[1], sums[2], sums[3], sums[4] = n, sx, sy, sz, xx
    sums[5], sums[6], sums[7], sums[8], sums[9] = xy, xz, yy, yz, zz


@njit(**INNER)
def grow_ball(scan, rules, room, p, r, c, first, layers, found):  # type: ignore[no-untyped-def]
    """Plane of point p in cell (r, c); `first` is its place in the tile, -1 when in none."""
    widths, sums, down, across = rules.widths, room.sums, scan.down, scan.across
    s = scan.slot[p]
    px, py, pz = scan.xyz[p, 0], scan.xyz[p, 1], scan.xyz[p, 2]
    dx, dy, dz = px - scan.scanner[0], py - scan.scanner[1], pz - scan.scanner[2]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if not (0.0 < distance < math.inf):
        return
    defined = False
    for g in range(widths.size):
        angle = math.asin(min(1.0, widths[g] / distance))
        high, wide = half_window(r, angle, down[c], across, down.size)
        if g > 0 and (2 * high + 1) * (2 * wide + 1) > rules.cells:
            break
        limit = widths[g] * widths[g]
        if first >= 0 and high < HALO and wide < LANES:
            sum_around(room.tile, first, layers, high, limit, room.own, room.lanes, sums)
        else:
            sum_cells(scan, r, c, high, wide, p, limit, sums)
        found.count[s] = int(sums[0])
        found.width[s] = widths[g]
        defined = covers_area(sums, px, py, pz, scan.scanner, widths[g])
        if sums[0] >= rules.enough and defined:
            break
    if defined:
        store_plane(sums, px, py, pz, scan.scanner, s, found.normals, found.rms)


@njit(**INNER)
def window_of(scan, who, at, r, c, width):  # type: ignore[no-untyped-def]
    """Rows and columns on either side that the lanes from cell (r, c) on need; -1: no lane."""
    xyz, slot, scanner, down = scan.xyz, scan.slot, scan.scanner, scan.down
    nearest, step = math.inf, math.inf
    for lane in range(min(LANES, down.size - c)):
        p = who[at + lane]
        if p >= 0 and slot[p] >= 0:
            dx, dy, dz = xyz[p, 0] - scanner[0], xyz[p, 1] - scanner[1], xyz[p, 2] - scanner[2]
            nearest = min(nearest, dx * dx + dy * dy + dz * dz)
            step = min(step, down[c + lane])
    if nearest == math.inf:
        return -1, -1
    angle = math.asin(min(1.0, width / math.sqrt(nearest)))
    return half_window(r, angle, step, scan.across, down.size)


@njit(**INNER)
def fit_lanes(scan, rules, room, at, layer, layers, r, c, found):  # type: ignore[no-untyped-def]
    """Planes of the points asked for in `LANES` cells of a layer, from cell (r, c) on."""
    who, own, lanes, planes, width = room.who, room.own, room.lanes, room.planes, rules.widths[0]
    slot, normals = scan.slot, found.normals
    who_at, first = layer * SIDE * SIDE + at, layer * LAYER + at
    high, wide = window_of(scan, who, who_at, r, c, width)
    if high < 0:
        return
    inside = high <= HALO and wide <= HALO - 2
    left_over = 0
    if inside:
        sum_lanes(room.tile, first, layers, high, wide, width * width, own, lanes)
        solve_lanes(lanes, own, scan.scanner, width, planes)
    for k in range(min(LANES, scan.down.size - c)):
        p = who[who_at + k]
        if p < 0 or slot[p] < 0:
            continue
        if not (
            inside
            and lanes[k] >= rules.enough
            and planes[4 * LANES + k] > 0.0
            and planes[5 * LANES + k] > 0.0
        ):
            left_over |= 1 << k
            continue
        s = slot[p]
        found.count[s] = int(lanes[k])
        found.width[s] = width
        normals[s, 0], normals[s, 1], normals[s, 2] = (
            planes[k], planes[LANES + k], planes[2 * LANES + k],
        )  # fmt: skip
        found.rms[s] = planes[3 * LANES + k]
    for k in range(LANES):
        if left_over >> k & 1:
            grow_ball(scan, rules, room, who[who_at + k], r, c + k, first + k, layers, found)


@njit(**INNER)
def fit_singly(scan, rules, room, top, left, found):  # type: ignore[no-untyped-def]
    """Planes of the points asked for in a tile that could not be loaded."""
    rows, columns = scan.across.size, scan.down.size
    nowhere, none = np.int64(-1), np.int64(0)  # literals would be compiled for once more
    for r in range(top, min(top + TILE, rows)):
        for c in range(left, min(left + TILE, columns)):
            p = scan.head[r * columns + c]
            while p >= 0:
                if scan.slot[p] >= 0:
                    grow_ball(scan, rules, room, p, r, c, nowhere, none, found)
                p = scan.after[p]


@njit(cache=True, nogil=True, error_model="numpy")
def fit_in_tiles(scan, rules, chosen, first, last, found):  # type: ignore[no-untyped-def]
    """Planes of the points in the tiles chosen[first:last], written to the slots asked for.

    The ball grows through the widths until it holds enough points, or until its window has
    too many cells: a point that finds no support in so many beams lies on nothing.
    """
    rows, columns = scan.across.size, scan.down.size
    room = Room(
        np.empty(LAYERS * LAYER), np.empty(LAYERS * SIDE * SIDE, np.int64), np.empty(3 * LANES),
        np.empty(SUMS * LANES), np.empty(PLANES * LANES), np.empty(SUMS),
    )  # fmt: skip
    tiles = -(-columns // TILE)
    # Around a narrow ring a tile's margin would meet its own cells again.
    ring = scan.seam and columns < SIDE
    for t in range(first, last):
        top, left = chosen[t] // tiles * TILE, chosen[t] % tiles * TILE
        layers = 0
        if not ring:
            layers = load_tile(scan, top - HALO, left - HALO, room.tile, room.who)
        if layers == 0:
            fit_singly(scan, rules, room, top, left, found)
            continue
        for i in range(min(TILE, rows - top)):
            for j in range(0, min(TILE, columns - left), LANES):
                at = (HALO + i) * SIDE + HALO + j
                for layer in range(layers):
                    fit_lanes(scan, rules, room, at, layer, layers, top + i, left + j, found)
