"""All sub-rays of a beam against one leaf at once, in loops that the compiler can widen.

No branch, no call and no early end inside them: four or eight sub-rays then go at a time. Offsets
are given by the beam's axes in the leaf's frame, abreast of the leaf: `axes` holds origin,
direction, left and up, `size` how far sub-rays have spread there and how fast they spread.
"""

import math

import numpy as np
from numba import njit

from app.core.kernels import INNER, SAFE
from app.core.kernels.vectors import dot

STEPS = 3
"""Newton steps from the tangent plane of the central ray: 1e-4, 1e-7, 1e-12 m."""
EXACT = 1e-11
"""Squared metres, all sub-rays together, of a last Newton step that leaves less than 1e-9 m."""


@njit(**INNER)
def inside(outline, x, y):  # type: ignore[no-untyped-def]
    """Whether a place lies in an egg without lobes; no branches."""
    s = x / outline[0]
    w = outline[1] * (1.0 - outline[2] * s)
    return (s * s < 1.0) & (y * y <= w * w * (1.0 - s * s))


@njit(**INNER)
def meet_flat(outline, axes, size, subrays, found):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| of each sub-ray on a flat leaf, inf where it misses."""
    o, d, left, up = axes
    lefts, ups = subrays[0], subrays[1]
    distance, facing = found[0], found[1]
    for k in range(len(lefts)):
        a, b = lefts[k], ups[k]
        x, y, z = a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2]
        dz = d[2] + size[1] * z
        t = -(o[2] + size[0] * z) / dz
        px = o[0] + size[0] * x + t * (d[0] + size[1] * x)
        py = o[1] + size[0] * y + t * (d[1] + size[1] * y)
        distance[k] = t if inside(outline, px, py) else np.inf
        facing[k] = abs(dz)


@njit(**INNER)
def meet_bent(outline, bend, axes, size, subrays, ahead, found):  # type: ignore[no-untyped-def]
    """The same on a leaf that is part of a cylinder of radius 1 / curvature.

    The other half of the cylinder is no leaf: there `lift` is negative. The scanner is `ahead`
    metres before the axes' origin: what lies behind it hides nothing.
    """
    o, d, left, up = axes
    lefts, ups = subrays[0], subrays[1]
    distance, facing = found[0], found[1]
    c = bend[0]
    for k in range(len(lefts)):
        a, b = lefts[k], ups[k]
        x, y, z = a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2]
        px, py, pz = o[0] + size[0] * x, o[1] + size[0] * y, o[2] + size[0] * z
        dx, dy, dz = d[0] + size[1] * x, d[1] + size[1] * y, d[2] + size[1] * z
        ps, ds = px * bend[1] + py * bend[2], dx * bend[1] + dy * bend[2]
        square = c * (ds * ds + dz * dz)
        half = c * ps * ds + (c * pz - 1.0) * dz
        rest = c * (ps * ps + pz * pz) - 2.0 * pz
        root = half * half - square * rest
        q = -(half + math.copysign(math.sqrt(max(root, 0.0)), half))
        one, two = rest / q, q / square
        first, second = min(one, two), max(one, two)
        lift_1, lift_2 = 1.0 - c * (pz + first * dz), 1.0 - c * (pz + second * dz)
        ok_1 = (
            (lift_1 > 0.0)
            & (first + ahead > 0.0)
            & inside(outline, px + first * dx, py + first * dy)
        )
        ok_2 = (lift_2 > 0.0) & inside(outline, px + second * dx, py + second * dy)
        t, lift = (first, lift_1) if ok_1 else (second, lift_2)
        distance[k] = t if (ok_1 | ok_2) & (root >= 0.0) else np.inf
        facing[k] = abs(c * (ps + t * ds) * ds - lift * dz)


@njit(**INNER)
def sine(x):  # type: ignore[no-untyped-def]
    """Sine to 1e-9; the library's cannot be widened."""
    turns = np.floor(x * (1.0 / math.pi) + 0.5)
    x -= turns * math.pi
    s = x * x
    y = s * (-1 / 39916800 + s * (1 / 6227020800))
    y = s * (-1 / 5040 + s * (1 / 362880 + y))
    y = x * (1.0 + s * (-1 / 6 + s * (1 / 120 + y)))
    odd = turns - 2.0 * np.floor(0.5 * turns)
    return y * (1.0 - 2.0 * odd)


@njit(**INNER, fastmath=SAFE)
def meet_gentle(outline, shape, axes, size, subrays, plane, found):  # type: ignore[no-untyped-def]
    """The same on a wrinkled leaf that each sub-ray can cross but once.

    `plane` is the tangent plane where the central ray ends: height at the origin, and slopes.
    Returns whether every sub-ray was followed to the leaf.
    """
    o, d, left, up = axes
    lefts, ups = subrays[0], subrays[1]
    distance, facing = found[0], found[1]
    (c, cos_bend, sin_bend), (size_z, u_rate, v_rate, u_phase, v_phase) = shape
    bent = 1.0 if c != 0.0 else 0.0
    over = 1.0 / c if c != 0.0 else 0.0
    quarter, missed = 0.5 * math.pi, 0.0
    for k in range(len(lefts)):
        a, b = lefts[k], ups[k]
        x, y, z = a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2]
        px, py, pz = o[0] + size[0] * x, o[1] + size[0] * y, o[2] + size[0] * z
        dx, dy, dz = d[0] + size[1] * x, d[1] + size[1] * y, d[2] + size[1] * z
        hx, hy = plane[1], plane[2]
        t = (plane[0] + hx * px + hy * py - pz) / (dz - hx * dx - hy * dy)
        f = 0.0
        for _ in range(STEPS):
            x, y = px + t * dx, py + t * dy
            s = c * (x * cos_bend + y * sin_bend)
            root = math.sqrt(max(1.0 - s * s, 0.05))
            u, v = u_rate * x + u_phase, v_rate * y + v_phase
            su, sv = sine(u), sine(v)
            h = (1.0 - root) * over + size_z * su * sv
            slope = bent * s / root
            hx = slope * cos_bend + size_z * u_rate * sine(u + quarter) * sv
            hy = slope * sin_bend + size_z * v_rate * su * sine(v + quarter)
            f = (pz + t * dz - h) / (dz - hx * dx - hy * dy)
            t -= f
        x, y = px + t * dx, py + t * dy
        distance[k] = t if inside(outline, x, y) else np.inf
        facing[k] = abs(dz - hx * dx - hy * dy) / math.sqrt(1.0 + hx * hx + hy * hy)
        missed += f * f
    # The last step was f; Newton's error after it is f² times the curvature.
    return missed < EXACT


@njit(**INNER)
def misses(outline, slab, steepest, radius, o, d):  # type: ignore[no-untyped-def]
    """Whether no sub-ray can meet a leaf that each can cross but once.

    A sub-ray `radius` away from the central ray crosses at most `stray` from where that does,
    since the height between the two places changes no faster than the steepest slope.
    """
    side = math.hypot(d[0], d[1])
    stray = radius * (1.0 + side * (1.0 + steepest) / (abs(d[2]) - steepest * side))
    stray += max(slab[1], -slab[0]) * side / abs(d[2])
    t = -o[2] / d[2]
    x, y = abs(o[0] + t * d[0]), abs(o[1] + t * d[1])
    return x > outline[0] + stray or y > outline[1] * (1.0 + abs(outline[2])) + stray


@njit(**INNER)
def clears(slab, reach, radius, o, d):  # type: ignore[no-untyped-def]
    """Whether no sub-ray can meet a leaf's bounding sphere within its slab."""
    middle = -dot(o, d)
    away2 = dot(o, o) - middle * middle
    limit = reach + radius
    if away2 > limit * limit:
        return True
    half = math.sqrt(limit * limit - away2)
    low, high = o[2] + (middle - half) * d[2], o[2] + (middle + half) * d[2]
    return min(low, high) > slab[1] + radius or max(low, high) < slab[0] - radius
