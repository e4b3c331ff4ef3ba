"""Share of each beam that lies on the surface of its own point, tile by tile of a range image.

The label of a beam is the surface that its range lies on. Labels are told cell by cell; between
two beams of different labels the edge may lie anywhere, so that a direction between beams is on
a surface to the share that interpolating their labels gives.
"""

import math

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.hit_pieces import HALO, MOST, load_piece, make_piece

FAINTEST = 0.03
"""A surface that fills less than this share of a beam is not reported."""
CONTRAST = 4.0
"""Ratio of the reflectances of two surfaces that is nothing unusual: leaf and wall, leaf and bark.
What 1 / r² makes of their light beyond it decides where one is reported beyond its edge."""
UNKNOWN, OTHER, BOTH, OWN = -1, 0, 1, 2
"""Labels; from 0 on, twice the share of a beam that lies on the own surface."""


@njit(**INNER)
def choose_start(piece, i, j, own, high, wide):  # type: ignore[no-untyped-def]
    """The beam of a surface around that is nearest in range; the point's own where it is one."""
    d, solid = piece.d, piece.solid
    if solid[i, j] and d[i, j] == own:
        return i, j
    best, far, at = math.inf, 0, (i, j)
    for a in range(i - high, i + high + 1):
        for b in range(j - wide, j + wide + 1):
            if not solid[a, b]:
                continue
            off, away = abs(d[a, b] - own), (a - i) * (a - i) + (b - j) * (b - j)
            if off < best or (off == best and away < far):
                best, far, at = off, away, (a, b)
    return at


@njit(**INNER)
def flood(piece, i, j, start, high, wide):  # type: ignore[no-untyped-def]
    """Label as OWN what is linked with the start inside the window, by surfaces alone if the
    start is part of one.
    """
    d, right, below, solid = piece.d, piece.right, piece.below, piece.solid
    label, queue = piece.label, piece.queue
    for a in range(MOST - high, MOST + high + 1):
        for b in range(MOST - wide, MOST + wide + 1):
            label[a, b] = UNKNOWN
    walls = solid[start[0], start[1]]
    label[start[0] - i + MOST, start[1] - j + MOST] = OWN
    queue[0, 0], queue[0, 1] = start
    head, tail = 0, 1
    while head < tail:
        a, b = queue[head, 0], queue[head, 1]
        head += 1
        for k in range(4):
            y, x = a + (k == 0) - (k == 1), b + (k == 2) - (k == 3)
            if abs(y - i) > high or abs(x - j) > wide or d[y, x] <= 0.0:
                continue
            if label[y - i + MOST, x - j + MOST] != UNKNOWN or (walls and not solid[y, x]):
                continue
            joined = below[min(a, y), x] if y != a else right[y, min(b, x)]
            if joined:
                label[y - i + MOST, x - j + MOST] = OWN
                queue[tail, 0], queue[tail, 1] = y, x
                tail += 1


@njit(**INNER)
def label_others(piece, i, j, own, high, wide):  # type: ignore[no-untyped-def]
    """Label the other surfaces in the window; returns the range nearest to the own one."""
    d, solid, label = piece.d, piece.solid, piece.label
    other = math.inf
    for a in range(i - high, i + high + 1):
        for b in range(j - wide, j + wide + 1):
            k, m = a - i + MOST, b - j + MOST
            if label[k, m] == UNKNOWN and solid[a, b]:
                label[k, m] = OTHER
                if abs(d[a, b] - own) < abs(other - own):
                    other = d[a, b]
    return other


@njit(**INNER)
def settle(piece, i, j, start, high, wide):  # type: ignore[no-untyped-def]
    """Label the rest: other surfaces as OTHER, mixed ranges by the surface that they are
    nearer to, beams with several returns as BOTH.

    Who reports several returns where there are several surfaces saw but one in this beam if it
    has one return: then the beams around with several say nothing against it.
    """
    d, several, label = piece.d, piece.several, piece.label
    own = d[start[0], start[1]]
    other = label_others(piece, i, j, own, high, wide)
    for a in range(i - high, i + high + 1):
        for b in range(j - wide, j + wide + 1):
            k, m = a - i + MOST, b - j + MOST
            if several[a, b]:
                label[k, m] = BOTH if several[i, j] else OWN
            elif label[k, m] == UNKNOWN and d[a, b] > 0.0:
                mine = abs(d[a, b] - own) <= abs(d[a, b] - other)
                label[k, m] = OWN if mine else OTHER
            elif d[a, b] == 0.0:
                mine = is_lone(d, label, a, b, k, m, high, wide)
                label[k, m] = OWN if mine else OTHER


@njit(**INNER)
def sum_up(piece, i, j, high, wide):  # type: ignore[no-untyped-def]
    """How many are OTHER, Σ 1 / r² of them, and the way to them."""
    d, label = piece.d, piece.label
    others = 0
    light, up, side = 0.0, 0.0, 0.0
    for a in range(-high, high + 1):
        for b in range(-wide, wide + 1):
            value = label[a + MOST, b + MOST]
            if value == OTHER:
                others += 1
                up += a
                side += b
                r = d[i + a, j + b]
                light += 1.0 / (r * r) if r > 0.0 else 0.0
    return others, light, up, side


@njit(**INNER)
def is_lone(d, label, a, b, k, m, high, wide):  # type: ignore[no-untyped-def]
    """Whether a beam without return is alone among those of the own surface: a dropout."""
    if not (0 < a < d.shape[0] - 1 and 0 < b < d.shape[1] - 1):
        return False
    for y in range(-1, 2):
        for x in range(-1, 2):
            if y == 0 and x == 0:
                continue
            if d[a + y, b + x] <= 0.0:
                return False
            inside = abs(k + y - MOST) <= high and abs(m + x - MOST) <= wide
            if inside and label[k + y, m + x] < BOTH:
                return False
    return True


@njit(**INNER)
def edge_shift(scene, own, light, others):  # type: ignore[no-untyped-def]
    """Beam radii by which the own surface ends before its labels do.

    A beam reports the surface that more light comes from. At the last label the own one's
    share f of the beam follows from f / r² = (1 - f) / r'², as far as no reflectances could make
    up for it: a near surface reaches beyond its edge until its share is too faint.
    """
    ratio = own * own * light / others
    ratio = max(1.0, ratio / CONTRAST) if ratio > 1.0 else min(1.0, ratio * CONTRAST)
    share = min(max(ratio / (1.0 + ratio), FAINTEST), 1.0 - FAINTEST)
    outwards = scene.outwards
    place = share * (len(outwards) - 1)
    k = min(int(place), len(outwards) - 2)
    return outwards[k] + (place - k) * (outwards[k + 1] - outwards[k])


@njit(**INNER)
def share_at(scene, piece, i, j, r, c, own):  # type: ignore[no-untyped-def]
    """Share of the beam in cell (i, j), at r and c of the grid, on the surface of range own."""
    angle = scene.radius / own + scene.spread
    high = angle / max(abs(scene.down[r]), 1e-9)
    wide = angle / max(abs(scene.turn[c]) * scene.level[r], 1e-9)
    high, wide = min(high, MOST - 1.0), min(wide, MOST - 1.0)
    tall, broad = math.ceil(high), math.ceil(wide)
    rough = piece.rough
    t, b, x, y = i - tall, i + tall + 1, j - broad, j + broad + 1
    single = own == piece.d[i, j]
    if single and rough[b, y] - rough[t, y] - rough[b, x] + rough[t, x] == 0:
        return 1.0
    start = choose_start(piece, i, j, own, tall, broad)
    flood(piece, i, j, start, tall, broad)
    settle(piece, i, j, start, tall, broad)
    others, light, up, side = sum_up(piece, i, j, tall, broad)
    if others == 0 and not piece.several[i, j]:
        return 1.0
    shift_y = shift_x = 0.0
    way = math.hypot(up / high, side / wide)
    if way > 0.0 and not piece.several[i, j]:
        shift = edge_shift(scene, piece.d[start[0], start[1]], light, others)
        shift_y, shift_x = shift * up / (high * way), shift * side / (wide * way)
    return integrate(scene, piece, r, c, high, wide, shift_y, shift_x)


@njit(**INNER)
def integrate(scene, piece, r, c, high, wide, shift_y, shift_x):  # type: ignore[no-untyped-def]
    """Sum of the beam's rays times the interpolated labels, `shift` radii off the rays."""
    rows, columns = scene.inverse.shape
    rays, label = scene.rays, piece.label
    tall, broad = math.ceil(high), math.ceil(wide)
    up, down = max(-tall, -r), min(tall, rows - 1 - r)
    left, right = (-broad, broad) if scene.seam else (max(-broad, -c), min(broad, columns - 1 - c))
    total = 0.0
    for k in range(rays.shape[1]):
        y = min(max((rays[0, k] + shift_y) * high, float(up)), float(down))
        x = min(max((rays[1, k] + shift_x) * wide, float(left)), float(right))
        a, b = math.floor(y), math.floor(x)
        y, x = y - a, x - b
        a1, b1 = min(a + 1, down), min(b + 1, right)
        value = (1.0 - y) * (1.0 - x) * label[a + MOST, b + MOST]
        value += (1.0 - y) * x * label[a + MOST, b1 + MOST]
        value += y * (1.0 - x) * label[a1 + MOST, b + MOST]
        value += y * x * label[a1 + MOST, b1 + MOST]
        total += rays[2, k] * value
    return total / OWN


@njit(cache=True, nogil=True, error_model="numpy")
def share_tiles(scene, number, slot, tiles, tile, found):  # type: ignore[no-untyped-def]
    """Fill `found` for the asked points that are the nearest in their cells, in some tiles.

    `slot` says for each point where its value goes, -1 nowhere.
    """
    piece = make_piece(tile)
    n = tile + 2 * HALO
    for k in range(len(tiles)):
        place = tiles[k]
        load_piece(scene, place, piece, n)
        for r in range(place[0], place[2]):
            for c in range(place[1], place[3]):
                p = number[r, c]
                if p == 0 or slot[p - 1] < 0:
                    continue
                i, j = r - place[0] + HALO, c - place[1] + HALO
                found[slot[p - 1]] = share_at(scene, piece, i, j, r, c, piece.d[i, j])


@njit(cache=True, nogil=True, error_model="numpy")
def share_hidden(scene, row, column, distance, tile, found):  # type: ignore[no-untyped-def]
    """The same for points behind others of their cell, each with its own range."""
    piece = make_piece(tile)
    n = tile + 2 * HALO
    place = np.full(4, -1, np.int64)
    for k in range(len(row)):
        r, c = row[k], column[k]
        if place[0] != r - r % tile or place[1] != c - c % tile:
            place[0], place[1] = r - r % tile, c - c % tile
            load_piece(scene, place, piece, n)
        i, j = r - place[0] + HALO, c - place[1] + HALO
        found[k] = share_at(scene, piece, i, j, r, c, distance[k])
