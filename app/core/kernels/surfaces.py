"""Sub-rays of one beam against leaves, stems and walls, and the normal where they end.

Arrays are taken out of their tables at the head of a function, never inside a loop: each taking
counts a reference, which threads would fight for.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.leaves import LeafTable, leaf_normal, meet_leaf
from app.core.kernels.rays import keep_nearer, localise, split
from app.core.kernels.vectors import along, dot, minus, take, turn_out


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


@njit(**INNER)
def meet_sphere(centre, radius, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a sphere."""
    p = minus(o, centre)
    half = dot(p, d)
    root = half * half - dot(d, d) * (dot(p, p) - radius * radius)
    if root <= 0.0:
        return np.inf, 0.0
    t = (-half - math.sqrt(root)) / dot(d, d)
    return t, abs(dot(minus(along(o, d, t), centre), d)) / radius


@njit(**INNER)
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


@njit(**INNER)
def meet_stem(stems, i, axes, beam, hits, index):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a cylinder with round ends."""
    subrays, found, size = beam.subrays, hits.found, (beam.exit_radius, beam.spread)
    start, end, radius = take(stems.start, i), take(stems.end, i), stems.radius[i]
    axis = minus(end, start)
    for k in range(subrays.shape[1]):
        o, d = split(axes, size, subrays[0, k], subrays[1, k])
        t, cosine = meet_cylinder(start, axis, radius, o, d)
        for centre in (start, end):
            other, facing = meet_sphere(centre, radius, o, d)
            if other < t:
                t, cosine = other, facing
        found[0, k], found[1, k] = t, cosine
    keep_nearer(hits, 0.0, index)


@njit(**INNER)
def meet_wall(walls, i, axes, beam, hits, index):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a rectangle."""
    lefts, ups, exit_radius, spread = (
        beam.subrays[0],
        beam.subrays[1],
        beam.exit_radius,
        beam.spread,
    )
    distance, facing = hits.found[0], hits.found[1]
    o, d, left, up = localise(take(walls.centre, i), walls.frame, i, axes)
    half_width, half_height = walls.half[i, 0], walls.half[i, 1]
    for k in range(len(lefts)):
        a, b = lefts[k], ups[k]
        x, y, z = a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2]
        dz = d[2] + spread * z
        t = -(o[2] + exit_radius * z) / dz
        px = o[0] + exit_radius * x + t * (d[0] + spread * x)
        py = o[1] + exit_radius * y + t * (d[1] + spread * y)
        distance[k] = t if (abs(px) <= half_width) & (abs(py) <= half_height) else np.inf
        facing[k] = abs(dz)
    keep_nearer(hits, 0.0, index)


@njit(**INNER)
def meet_surface(table, surface, column, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against one surface."""
    leaves, stems = len(table.leaves.centre), len(table.stems.radius)
    if surface < leaves:
        meet_leaf(table.leaves, surface, column, axes, beam, hits)
    elif surface < leaves + stems:
        meet_stem(table.stems, surface - leaves, axes, beam, hits, surface)
    else:
        meet_wall(table.walls, surface - leaves - stems, axes, beam, hits, surface)


@njit(**INNER)
def stem_normal(stems, i, point):  # type: ignore[no-untyped-def]
    """Normal of a stem at a point of it, of any length."""
    start = take(stems.start, i)
    axis = minus(take(stems.end, i), start)
    length2 = dot(axis, axis)
    place = dot(minus(point, start), axis) / length2 if length2 > 0.0 else 0.0
    return minus(point, along(start, axis, min(max(place, 0.0), 1.0)))


@njit(**INNER)
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
