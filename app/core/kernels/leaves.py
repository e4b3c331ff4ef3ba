"""One leaf against the sub-rays of a beam, ray by ray where they may cross it more than once."""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER, leaf_rays
from app.core.kernels.rays import keep_nearer, localise, split
from app.core.kernels.vectors import along, dot, minus, take, turn_in, turn_out

MARCH = 0.004
"""Longest sideways step, metres, in which a wrinkled leaf is searched for its first crossing."""
FINE = 16.0
"""Steps to a wave."""
REFINEMENTS = 20
CLOSE = 3e-6
"""Metres: a Newton step shorter than this leaves an error of its square times the curvature."""


class LeafTable(NamedTuple):
    """Leaves as arrays, one row each."""

    centre: Any  # (n, 3) m
    frame: Any  # (n, 3, 3): rows along, across, normal
    outline: Any  # (n, 5): half length, half width, taper, lobes, lobe depth
    bend: Any  # (n, 3): curvature, cos and sin of its direction in the leaf
    wrinkle: Any  # (n, 5): height, wave numbers along and across, phases
    slab: Any  # (n, 2): lowest and highest height over the local plane
    reach: Any  # (n, 2): radius of a sphere about the centre that holds it, m; steepest slope
    sway: Any  # (n, 5): displacement, m; rate per column and phase, radians


@njit(**INNER)
def displaced(leaves, i, column):  # type: ignore[no-untyped-def]
    """Centre of a leaf while the scanner measures a column."""
    sway = leaves.sway
    c = take(leaves.centre, i)
    if sway[i, 3] == 0.0:
        return c
    s = math.sin(sway[i, 3] * column + sway[i, 4])
    return (c[0] + s * sway[i, 0], c[1] + s * sway[i, 1], c[2] + s * sway[i, 2])


@njit(**INNER)
def height(shape, x, y):  # type: ignore[no-untyped-def]
    """Height of a leaf over its plane, and its slopes along and across."""
    bend, wrinkle = shape
    h, hx, hy = 0.0, 0.0, 0.0
    if bend[0] != 0.0:
        s = bend[0] * (x * bend[1] + y * bend[2])
        root = math.sqrt(max(1.0 - s * s, 0.05))
        h = (1.0 - root) / bend[0]
        hx, hy = s / root * bend[1], s / root * bend[2]
    if wrinkle[0] != 0.0:
        u, v = wrinkle[1] * x + wrinkle[3], wrinkle[2] * y + wrinkle[4]
        su, sv = math.sin(u), math.sin(v)
        h += wrinkle[0] * su * sv
        hx += wrinkle[0] * wrinkle[1] * math.cos(u) * sv
        hy += wrinkle[0] * wrinkle[2] * su * math.cos(v)
    return h, hx, hy


@njit(**INNER)
def shape_of(leaves, i):  # type: ignore[no-untyped-def]
    """Bend and wrinkle of a leaf as tuples."""
    w = leaves.wrinkle
    return take(leaves.bend, i), (w[i, 0], w[i, 1], w[i, 2], w[i, 3], w[i, 4])


@njit(**INNER)
def outline_of(leaves, i):  # type: ignore[no-untyped-def]
    """Outline of a leaf as a tuple."""
    a = leaves.outline
    return (a[i, 0], a[i, 1], a[i, 2], a[i, 3], a[i, 4])


@njit(**INNER)
def within(outline, x, y):  # type: ignore[no-untyped-def]
    """Whether a place of the local plane lies inside the outline: an egg, perhaps lobed."""
    if outline[3] > 0.0:
        angle = math.atan2(y / outline[1], x / outline[0])
        f = 1.0 - 0.5 * outline[4] * (1.0 - math.cos(outline[3] * angle))
        x, y = x / f, y / f
    s = x / outline[0]
    if s * s >= 1.0:
        return False
    w = outline[1] * (1.0 - outline[2] * s)
    return y * y <= w * w * (1.0 - s * s)


@njit(**INNER)
def meet_slab(slab, radius, o, d):  # type: ignore[no-untyped-def]
    """Stretch of a ray inside a leaf's bounding sphere and slab; empty when high < low."""
    middle = -dot(o, d)
    half = middle * middle - dot(o, o) + radius * radius
    if half <= 0.0:
        return 1.0, 0.0
    half = math.sqrt(half)
    low, high = middle - half, middle + half
    if d[2] != 0.0:
        a, b = (slab[0] - o[2]) / d[2], (slab[1] - o[2]) / d[2]
        low, high = max(low, min(a, b)), min(high, max(a, b))
    return low, high


@njit(**INNER)
def refine(shape, o, d, low, high, rises, t):  # type: ignore[no-untyped-def]
    """Crossing of a leaf's height between two distances, from a first guess.

    Newton steps are kept inside the bracket, so that a grazing ray cannot run away. `rises` says
    whether the ray is over the leaf at `low`. Returns the distance and the slopes there.
    """
    hx, hy = 0.0, 0.0
    for _ in range(REFINEMENTS):
        h, hx, hy = height(shape, o[0] + t * d[0], o[1] + t * d[1])
        f, slope = o[2] + t * d[2] - h, d[2] - hx * d[0] - hy * d[1]
        if (f > 0.0) == rises:
            low = t
        else:
            high = t
        step = t - f / slope if slope != 0.0 else low
        if not low <= step <= high:
            step = 0.5 * (low + high)
        moved = abs(step - t)
        t = step
        if moved < CLOSE:
            break
    return t, hx, hy


@njit(**INNER)
def face(d, hx, hy):  # type: ignore[no-untyped-def]
    """|cos ω| of a ray on a surface of given slopes."""
    return abs(d[2] - hx * d[0] - hy * d[1]) / math.sqrt(1.0 + hx * hx + hy * hy)


@njit(**INNER)
def march(outline, shape, span, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| of the first crossing of a leaf within `span`."""
    low, high = span
    pace = MARCH
    if shape[1][0] != 0.0:
        pace = min(pace, 2.0 * math.pi / (FINE * max(shape[1][1], shape[1][2])))
    steps = 1 + int((high - low) * math.hypot(d[0], d[1]) / pace)
    step = (high - low) / steps
    f_low = o[2] + low * d[2] - height(shape, o[0] + low * d[0], o[1] + low * d[1])[0]
    for k in range(steps):
        stop = low + (k + 1) * step
        f_high = o[2] + stop * d[2] - height(shape, o[0] + stop * d[0], o[1] + stop * d[1])[0]
        if (f_low > 0.0) != (f_high > 0.0):
            guess = stop - step * f_high / (f_high - f_low)
            t, hx, hy = refine(shape, o, d, stop - step, stop, f_low > 0.0, guess)
            if within(outline, o[0] + t * d[0], o[1] + t * d[1]):
                return t, face(d, hx, hy)
        f_low = f_high
    return np.inf, 0.0


@njit(**INNER)
def touch(shape, slab, o, d):  # type: ignore[no-untyped-def]
    """Tangent plane where a ray crosses a leaf that it can cross but once, outline or not.

    Returns the height over the origin, and the slopes.
    """
    a, b = (slab[0] - o[2]) / d[2], (slab[1] - o[2]) / d[2]
    low, high = min(a, b), max(a, b)
    t, hx, hy = refine(shape, o, d, low, high, d[2] < 0.0, 0.5 * (low + high))
    x, y, z = along(o, d, t)
    return z - hx * x - hy * y, hx, hy


@njit(**INNER)
def meet_each(outline, shape, bounds, axes, size, subrays, ahead, found):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| of each sub-ray on a leaf of any shape, inf where it misses."""
    slab, reach = bounds
    for k in range(subrays.shape[1]):
        o, d = split(axes, size, subrays[0, k], subrays[1, k])
        found[0, k] = np.inf
        low, high = meet_slab(slab, reach, o, d)
        low = max(low, -ahead)  # what lies behind the scanner hides nothing
        if low < high:
            found[0, k], found[1, k] = march(outline, shape, (low, high), o, d)


@njit(**INNER)
def meet_leaf(leaves, i, column, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against one leaf."""
    axes = localise(displaced(leaves, i, column), leaves.frame, i, axes)
    o, d, left, up = axes
    # A sub-ray starts abreast of the leaf, as far from the axis as it has spread by then.
    ahead = -dot(o, d)
    size = (beam.exit_radius + ahead * beam.spread, beam.spread)
    o = along(o, d, ahead)
    axes = (o, d, left, up)
    slab, reach, steepest = (
        (leaves.slab[i, 0], leaves.slab[i, 1]),
        leaves.reach[i, 0],
        leaves.reach[i, 1],
    )
    outline, shape = outline_of(leaves, i), shape_of(leaves, i)
    gentle = steepest * math.hypot(d[0], d[1]) < 0.9 * abs(d[2])
    if gentle:
        if leaf_rays.misses(outline, slab, steepest, size[0], o, d):
            return
    elif leaf_rays.clears(slab, reach, size[0], o, d):
        return
    bent, wrinkled = shape[0][0] != 0.0, shape[1][0] != 0.0
    if outline[3] > 0.0 or (wrinkled and not gentle):
        meet_each(outline, shape, (slab, reach), axes, size, beam.subrays, ahead, hits.found)
    elif wrinkled:
        plane = touch(shape, slab, o, d)
        if not leaf_rays.meet_gentle(outline, shape, axes, size, beam.subrays, plane, hits.found):
            meet_each(outline, shape, (slab, reach), axes, size, beam.subrays, ahead, hits.found)
    elif bent:
        leaf_rays.meet_bent(outline, shape[0], axes, size, beam.subrays, ahead, hits.found)
    else:
        leaf_rays.meet_flat(outline, axes, size, beam.subrays, hits.found)
    keep_nearer(hits, ahead, i)


@njit(**INNER)
def leaf_normal(leaves, i, column, point):  # type: ignore[no-untyped-def]
    """Normal of a leaf at a point of it, of any length."""
    p = turn_in(leaves.frame, i, minus(point, displaced(leaves, i, column)))
    _, hx, hy = height(shape_of(leaves, i), p[0], p[1])
    return turn_out(leaves.frame, i, (-hx, -hy, 1.0))
