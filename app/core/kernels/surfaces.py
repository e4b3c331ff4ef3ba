"""Sub-rays of one beam against leaves, stems and walls, and the normal where they end.

Arrays are taken out of their tables at the head of a function, never inside a loop: each taking
counts a reference, which threads would fight for.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels.vectors import along, dot, minus, take, turn_in, turn_out

MARCH = 0.004
"""Sideways step, metres, in which a wrinkled leaf is searched for its first crossing."""
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


class StemTable(NamedTuple):
    """Stems: cylinders with round ends."""

    start: Any  # (n, 3) m
    end: Any  # (n, 3) m
    radius: Any  # (n,) m


class WallTable(NamedTuple):
    """Plane rectangles."""

    centre: Any  # (n, 3) m
    frame: Any  # (n, 3, 3): rows across, up, normal
    half: Any  # (n, 2): half width and half height, m


class SurfaceTable(NamedTuple):
    """All surfaces; their index runs over leaves, then stems, then walls."""

    leaves: LeafTable
    stems: StemTable
    walls: WallTable


class HitTable(NamedTuple):
    """First crossing of each sub-ray of a beam; distance inf and surface −1 where there is none."""

    distance: Any  # (k,) m
    facing: Any  # (k,) cos ω
    surface: Any  # (k,) int64


@njit(cache=True, nogil=True, error_model="numpy")
def split(axes, size, a, b):  # type: ignore[no-untyped-def]
    """Start and direction of the sub-ray at offset (a, b); `size`: exit radius and spread."""
    o, d, left, up = axes
    offset = (a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2])
    return along(o, offset, size[0]), along(d, offset, size[1])


@njit(cache=True, nogil=True, error_model="numpy")
def localise(centre, frames, i, axes):  # type: ignore[no-untyped-def]
    """Origin, direction, left and up of a beam in the frame of a surface."""
    origin, d, left, up = axes
    o = turn_in(frames, i, minus(origin, centre))
    return o, turn_in(frames, i, d), turn_in(frames, i, left), turn_in(frames, i, up)


@njit(cache=True, nogil=True, error_model="numpy")
def displaced(leaves, i, column):  # type: ignore[no-untyped-def]
    """Centre of a leaf while the scanner measures a column."""
    sway = leaves.sway
    c = take(leaves.centre, i)
    if sway[i, 3] == 0.0:
        return c
    s = math.sin(sway[i, 3] * column + sway[i, 4])
    return (c[0] + s * sway[i, 0], c[1] + s * sway[i, 1], c[2] + s * sway[i, 2])


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def shape_of(leaves, i):  # type: ignore[no-untyped-def]
    """Bend and wrinkle of a leaf as tuples."""
    w = leaves.wrinkle
    return take(leaves.bend, i), (w[i, 0], w[i, 1], w[i, 2], w[i, 3], w[i, 4])


@njit(cache=True, nogil=True, error_model="numpy")
def outline_of(leaves, i):  # type: ignore[no-untyped-def]
    """Outline of a leaf as a tuple."""
    a = leaves.outline
    return (a[i, 0], a[i, 1], a[i, 2], a[i, 3], a[i, 4])


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def meet_flat(outline, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a flat leaf."""
    if d[2] == 0.0:
        return np.inf, 0.0
    t = -o[2] / d[2]
    if within(outline, o[0] + t * d[0], o[1] + t * d[1]):
        return t, abs(d[2])
    return np.inf, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def meet_bent(outline, bend, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a leaf that is part of a cylinder of radius 1 / curvature.

    The origin must be near the leaf, or the discriminant loses its digits.
    """
    c = bend[0]
    ps, ds = o[0] * bend[1] + o[1] * bend[2], d[0] * bend[1] + d[1] * bend[2]
    a = c * (ds * ds + d[2] * d[2])
    b = c * ps * ds + (c * o[2] - 1.0) * d[2]
    e = c * (ps * ps + o[2] * o[2]) - 2.0 * o[2]
    root = b * b - a * e
    if root < 0.0:
        return np.inf, 0.0
    q = -(b + math.copysign(math.sqrt(root), b))
    first = e / q if q != 0.0 else np.inf
    second = q / a if a != 0.0 else np.inf
    for t in (min(first, second), max(first, second)):
        lift = 1.0 - c * (o[2] + t * d[2])
        # The other half of the cylinder is no leaf.
        if lift > 0.0 and within(outline, o[0] + t * d[0], o[1] + t * d[1]):
            return t, abs(c * (ps + t * ds) * ds - lift * d[2])
    return np.inf, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def face(d, hx, hy):  # type: ignore[no-untyped-def]
    """|cos ω| of a ray on a surface of given slopes."""
    return abs(d[2] - hx * d[0] - hy * d[1]) / math.sqrt(1.0 + hx * hx + hy * hy)


@njit(cache=True, nogil=True, error_model="numpy")
def meet_gentle(outline, shape, slab, o, d, near):  # type: ignore[no-untyped-def]
    """Distance, |cos ω| and tangent plane where a ray crosses a leaf that it can cross but once.

    `near` is the tangent plane where the sub-ray before ended: (height at the origin, slopes).
    """
    a, b = (slab[0] - o[2]) / d[2], (slab[1] - o[2]) / d[2]
    low, high = min(a, b), max(a, b)
    lift = near[0] + near[1] * o[0] + near[2] * o[1] - o[2]
    t = lift / (d[2] - near[1] * d[0] - near[2] * d[1])
    if not low < t < high:
        t = 0.5 * (low + high)
    t, hx, hy = refine(shape, o, d, low, high, d[2] < 0.0, t)
    x, y, z = along(o, d, t)
    plane = (z - hx * x - hy * y, hx, hy)
    if within(outline, x, y):
        return t, face(d, hx, hy), plane
    return np.inf, 0.0, plane


@njit(cache=True, nogil=True, error_model="numpy")
def meet_wrinkled(outline, shape, span, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| of the first crossing of a wrinkled leaf within `span`."""
    low, high = span
    steps = 1 + int((high - low) * math.hypot(d[0], d[1]) / MARCH)
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def meet_leaf(leaves, i, column, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against one leaf."""
    rays, size = beam.subrays, (beam.exit_radius, beam.spread)
    distance, facing, surface = hits.distance, hits.facing, hits.surface
    o, d, left, up = localise(displaced(leaves, i, column), leaves.frame, i, axes)
    ahead = -dot(o, d)
    # A sub-ray starts abreast of the leaf, as far from the axis as it has spread by then.
    size = (size[0] + ahead * size[1], size[1])
    axes = (along(o, d, ahead), d, left, up)
    outline, shape = outline_of(leaves, i), shape_of(leaves, i)
    slab, reach = (leaves.slab[i, 0], leaves.slab[i, 1]), leaves.reach[i, 0]
    gentle = leaves.reach[i, 1] * math.hypot(d[0], d[1]) < 0.9 * abs(d[2])
    if gentle and misses(outline, slab, leaves.reach[i, 1], size[0], axes[0], d):
        return
    plane = (0.0, 0.0, 0.0)
    for k in range(len(rays)):
        o, d = split(axes, size, rays[k, 0], rays[k, 1])
        t, cosine = np.inf, 0.0
        if shape[1][0] != 0.0 and gentle:
            t, cosine, plane = meet_gentle(outline, shape, slab, o, d, plane)
        elif shape[1][0] != 0.0:
            span = meet_slab(slab, reach, o, d)
            if span[0] < span[1]:
                t, cosine = meet_wrinkled(outline, shape, span, o, d)
        elif shape[0][0] != 0.0:
            t, cosine = meet_bent(outline, shape[0], o, d)
        else:
            t, cosine = meet_flat(outline, o, d)
        t += ahead
        if 0.0 < t < distance[k]:
            distance[k], facing[k], surface[k] = t, min(cosine, 1.0), i


@njit(cache=True, nogil=True, error_model="numpy")
def meet_sphere(centre, radius, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a sphere."""
    p = minus(o, centre)
    half = dot(p, d)
    root = half * half - dot(d, d) * (dot(p, p) - radius * radius)
    if root <= 0.0:
        return np.inf, 0.0
    t = (-half - math.sqrt(root)) / dot(d, d)
    return t, abs(dot(minus(along(o, d, t), centre), d)) / radius


@njit(cache=True, nogil=True, error_model="numpy")
def meet_cylinder(start, axis, radius, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a cylinder without ends."""
    p = minus(o, start)
    length2, ad, ap = dot(axis, axis), dot(axis, d), dot(axis, p)
    a = dot(d, d) - ad * ad / length2
    b = dot(d, p) - ad * ap / length2
    root = b * b - a * (dot(p, p) - ap * ap / length2 - radius * radius)
    if root <= 0.0 or a <= 0.0:
        return np.inf, 0.0
    t = (-b - math.sqrt(root)) / a
    place = (ap + t * ad) / length2
    if place < 0.0 or place > 1.0:
        return np.inf, 0.0
    foot = along(start, axis, place)
    return t, abs(dot(minus(along(o, d, t), foot), d)) / radius


@njit(cache=True, nogil=True, error_model="numpy")
def meet_stem(stems, i, axes, beam, hits, index):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a cylinder with round ends."""
    rays, size = beam.subrays, (beam.exit_radius, beam.spread)
    distance, facing, surface = hits.distance, hits.facing, hits.surface
    start, end, radius = take(stems.start, i), take(stems.end, i), stems.radius[i]
    axis = minus(end, start)
    for k in range(len(rays)):
        o, d = split(axes, size, rays[k, 0], rays[k, 1])
        for part in range(3):
            if part == 0:
                t, cosine = meet_cylinder(start, axis, radius, o, d)
            else:
                t, cosine = meet_sphere(start if part == 1 else end, radius, o, d)
            if 0.0 < t < distance[k]:
                distance[k], facing[k], surface[k] = t, min(cosine, 1.0), index


@njit(cache=True, nogil=True, error_model="numpy")
def meet_wall(walls, i, axes, beam, hits, index):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a rectangle."""
    rays, size = beam.subrays, (beam.exit_radius, beam.spread)
    distance, facing, surface = hits.distance, hits.facing, hits.surface
    axes = localise(take(walls.centre, i), walls.frame, i, axes)
    half_width, half_height = walls.half[i, 0], walls.half[i, 1]
    for k in range(len(rays)):
        o, d = split(axes, size, rays[k, 0], rays[k, 1])
        t = -o[2] / d[2] if d[2] != 0.0 else -1.0
        inside = abs(o[0] + t * d[0]) <= half_width and abs(o[1] + t * d[1]) <= half_height
        if inside and 0.0 < t < distance[k]:
            distance[k], facing[k], surface[k] = t, min(abs(d[2]), 1.0), index


@njit(cache=True, nogil=True, error_model="numpy")
def meet_surface(table, surface, column, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against one surface."""
    leaves, stems = len(table.leaves.centre), len(table.stems.radius)
    if surface < leaves:
        meet_leaf(table.leaves, surface, column, axes, beam, hits)
    elif surface < leaves + stems:
        meet_stem(table.stems, surface - leaves, axes, beam, hits, surface)
    else:
        meet_wall(table.walls, surface - leaves - stems, axes, beam, hits, surface)


@njit(cache=True, nogil=True, error_model="numpy")
def leaf_normal(leaves, i, column, point):  # type: ignore[no-untyped-def]
    """Normal of a leaf at a point of it, of any length."""
    p = turn_in(leaves.frame, i, minus(point, displaced(leaves, i, column)))
    _, hx, hy = height(shape_of(leaves, i), p[0], p[1])
    return turn_out(leaves.frame, i, (-hx, -hy, 1.0))


@njit(cache=True, nogil=True, error_model="numpy")
def stem_normal(stems, i, point):  # type: ignore[no-untyped-def]
    """Normal of a stem at a point of it, of any length."""
    start = take(stems.start, i)
    axis = minus(take(stems.end, i), start)
    length2 = dot(axis, axis)
    place = dot(minus(point, start), axis) / length2 if length2 > 0.0 else 0.0
    return minus(point, along(start, axis, min(max(place, 0.0), 1.0)))


@njit(cache=True, nogil=True, error_model="numpy")
def face_normal(table, surface, column, ray):  # type: ignore[no-untyped-def]
    """Unit normal of a surface where the ray (origin, direction, distance) ends, facing back."""
    o, d, t = ray
    point = along(o, d, t)
    leaves, stems = len(table.leaves.centre), len(table.stems.radius)
    if surface < leaves:
        n = leaf_normal(table.leaves, surface, column, point)
    elif surface < leaves + stems:
        n = stem_normal(table.stems, surface - leaves, point)
    else:
        n = turn_out(table.walls.frame, surface - leaves - stems, (0.0, 0.0, 1.0))
    size = math.sqrt(dot(n, n))
    if dot(n, d) > 0.0:
        size = -size
    return (n[0] / size, n[1] / size, n[2] / size)
