"""Planes at the points of a range image, tile by tile."""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.bends import make_bends, mean_bends, measure_bends
from app.core.kernels.careful import fit_careful, make_room
from app.core.kernels.tiles import load_tile, make_tile
from app.core.kernels.windows import fit_beside, fit_undisturbed
from app.core.normals.rules import HALO, REACH

FLATTENED = 0.035
"""Of the change of the change of slope from window to window, what a window of that size does not
follow: 1/40 on long waves to 1/16 on those of four half-widths."""

EDGES = 3.0
"""Windows off their cell lie at the edges of leaves, and there leaves bend most."""

DEFERRED = -1
FAN = 0.04
"""Radians of azimuth, on either side, over which columns are parallel enough."""
NARROW = 3.0
"""Rows that the widest window of columns must be as wide as."""


class Found(NamedTuple):
    """Results by slot: one row per point asked for."""

    normals: Any  # (k, 3)
    count: Any  # (k,)
    width: Any  # (k,) metres
    rms: Any  # (k,) metres
    sigma: Any  # (k,) radians


@njit(**INNER, forceinline=True)
def store(image, found, slot, p, down, turn, base, width, bend, twist, fit):  # type: ignore[no-untyped-def]
    """Turn a fit at point p into a normal towards the scanner, its width, rms and σ."""
    count, high, wide, off_i, off_j, value, a, b, vii, vjj, vij, square = fit
    xyz, scanner, axes = image.xyz, image.scanner, image.axes
    dx, dy, dz = xyz[p, 0] - scanner[0], xyz[p, 1] - scanner[1], xyz[p, 2] - scanner[2]
    ux = axes[0, 0] * dx + axes[0, 1] * dy + axes[0, 2] * dz
    uy = axes[1, 0] * dx + axes[1, 1] * dy + axes[1, 2] * dz
    uz = axes[2, 0] * dx + axes[2, 1] * dy + axes[2, 2] * dz
    size = 1.0 / math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux * size, uy * size, uz * size
    flat = math.sqrt(ux * ux + uy * uy)
    side = turn * flat
    w = value + base
    up, left = a / down, b / side
    # Rows are arcs, and 1 / range bends even along a plane: what that makes of the slope of a
    # window whose middle lies off the beam, in the plane across the beam.
    high_off, side_off, arc = off_i * down, off_j * side, uz / flat
    up, left = (
        up + w * high_off + arc * left * side_off,
        left + w * side_off - arc * (up * side_off - left * high_off),
    )
    # In the scanner's axes: w along the beam, and the gradient along up and left.
    lx, ly = ux / flat, uy / flat
    x = w * ux - up * uz * lx - left * ly
    y = w * uy - up * uz * ly + left * lx
    z = w * uz + up * flat
    long = math.sqrt(x * x + y * y + z * z)
    x, y, z = -x / long, -y / long, -z / long
    found.normals[slot, 0] = axes[0, 0] * x + axes[1, 0] * y + axes[2, 0] * z
    found.normals[slot, 1] = axes[0, 1] * x + axes[1, 1] * y + axes[2, 1] * z
    found.normals[slot, 2] = axes[0, 2] * x + axes[1, 2] * y + axes[2, 2] * z
    steep = up * up + left * left
    vu, vl, vul = vii / (down * down), vjj / (side * side), vij / (down * side)
    variance = 0.5 * (vu + vl)
    if steep > 0.0:
        variance = (up * up * vu + left * left * vl + 2.0 * up * left * vul) / steep
    reach = max(high * abs(down), wide * abs(side)) / w
    # Few cells tell their own noise badly: Student's t instead of the normal distribution.
    variance *= 1.0 + 2.0 / max(count - 3, 1)
    variance += EDGES * w * w * bend * (off_i * off_i * down * down + off_j * off_j * side * side)
    variance += w * w * twist * (FLATTENED * (reach / width) ** 2) ** 2
    sigma = math.sqrt(max(variance, 0.0)) * w / (long * long)
    found.sigma[slot] = sigma if sigma < 0.5 * math.pi else math.nan  # then it tells nothing
    found.count[slot] = count
    found.width[slot] = reach
    # Distance from the plane: the residual of the range, seen at the angle of incidence.
    found.rms[slot] = math.sqrt(square) / (w * long)


@njit(**INNER, forceinline=True)
def is_uneven(image, r, c, w, rules):  # type: ignore[no-untyped-def]
    """Whether rows and columns around a cell are no even lattice as the scanner sees them.

    So it is where steps change, and at a pole: columns fan out there, and a window of them is
    bent, or too narrow.
    """
    down, turn, level = image.down[r], abs(image.turn[c]), image.level[r]
    fan = min(REACH * turn * level, rules.widths[-1] * w)
    return (
        image.uneven_row[r] or image.uneven_column[c]
        or fan > FAN * level or REACH * turn * level < NARROW * abs(down)
    )  # fmt: skip


@njit(**INNER, forceinline=True)
def is_bent(bend, w, down, side, rules):  # type: ignore[no-untyped-def]
    """Whether the bend turns a half window from its middle to the cell more than noise does."""
    reach = rules.beside * w
    cells = 2.0 * reach * reach / abs(down * side)
    noise = 12.0 * (rules.noise * w) ** 2
    return bend * (0.5 * reach) ** 2 * cells * reach * reach > rules.bent * noise


@njit(**INNER)
def leave(found, slot, count):  # type: ignore[no-untyped-def]
    """Say that there is no plane; a count of `DEFERRED`: that it must be found in another way."""
    for axis in range(3):
        found.normals[slot, axis] = math.nan
    found.count[slot] = count
    found.width[slot] = 0.0
    found.rms[slot] = math.nan
    found.sigma[slot] = math.nan


@njit(**INNER)
def fit_calm_cells(image, tile, base, place, slot, rules, found, bends, rest):  # type: ignore[no-untyped-def]
    """Planes of a tile's points from undisturbed windows; the cells that have none go to `rest`.

    Returns how many these are.
    """
    number, down, turn, level = image.number, image.down, image.turn, image.level
    w = tile.w
    left = 0
    for r in range(place[0], place[2]):
        i = r - place[0] + HALO
        for c in range(place[1], place[3]):
            j = c - place[1] + HALO
            p = number[r, c] - 1
            if p < 0:
                continue
            k = slot[r, c] - 1 if slot.size else p
            side = turn[c] * level[r]
            own = w[i, j] + base
            if k < 0:
                continue
            uneven = is_uneven(image, r, c, own, rules)
            if uneven or max(abs(down[r]), abs(side)) > rules.widest * own:
                leave(found, k, DEFERRED if uneven else 0)
                continue
            bend, twist = mean_bends(bends, i, j)
            calm = twist <= rules.wrinkled
            most = rules.widths.size if calm else 1
            fit = fit_undisturbed(tile, base, i, j, down[r], side, most, rules)
            if calm and fit[0] == 0 and not is_bent(bend, own, down[r], side, rules):
                fit = fit_beside(tile, base, i, j, down[r], side, rules)
            if fit[0] > 0:
                store(image, found, k, p, down[r], turn[c], base, rules.widths[0], bend, twist, fit)
            else:
                rest[left] = i * w.shape[0] + j
                left += 1
    return left


@njit(**INNER)
def fit_other_cells(image, tile, base, place, slot, rules, found, bends, rest, left, room):  # type: ignore[no-untyped-def]
    """Robust planes of the first `left` cells in `rest`."""
    number, down, turn, level = image.number, image.down, image.turn, image.level
    w = tile.w
    size = w.shape[0]
    for k in range(left):
        i, j = rest[k] // size, rest[k] % size
        r, c = place[0] - HALO + i, place[1] - HALO + j
        p = number[r, c] - 1
        s = slot[r, c] - 1 if slot.size else p
        bend, twist = mean_bends(bends, i, j)
        side = turn[c] * level[r]
        narrow = twist > rules.wrinkled or is_bent(bend, w[i, j] + base, down[r], side, rules)
        width = rules.widths[0] if narrow else rules.careful
        fit = fit_careful(tile, base, i, j, down[r], side, rules, width, room)
        if fit[0] > 0:
            store(image, found, s, p, down[r], turn[c], base, rules.widths[0], bend, twist, fit)
        else:
            leave(found, s, 0)


@njit(cache=True, nogil=True, error_model="numpy")
def fit_tiles(image, slot, tiles, size, rules, found):  # type: ignore[no-untyped-def]
    """Planes of the points asked for in rectangles (t, 4) of at most size × size cells.

    A rectangle is: first row, first column, row and column after the last. `slot`
    is, by cell, where its result goes, from 1; empty: all, by point. What has no plane is NaN.
    """
    tile = make_tile(size + 2 * HALO)
    room = make_room()
    bends = make_bends(size)
    rest = np.empty(size * size, np.int64)
    for t in range(len(tiles)):
        place = tiles[t]
        base = load_tile(image, place, tile, rules.slope, rules.jump * rules.noise)
        measure_bends(image, tile, base, place, rules.widths[0], bends)
        left = fit_calm_cells(image, tile, base, place, slot, rules, found, bends, rest)
        fit_other_cells(image, tile, base, place, slot, rules, found, bends, rest, left, room)
