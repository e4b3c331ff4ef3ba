"""The sub-rays of one beam, and the nearest crossing of each so far."""

from typing import Any, NamedTuple

from numba import njit

from app.core.kernels import INNER
from app.core.kernels.vectors import along, minus, turn_in


class HitTable(NamedTuple):
    """First crossing of each sub-ray of a beam; distance inf and surface −1 where there is none."""

    distance: Any  # (k,) m
    facing: Any  # (k,) cos ω
    surface: Any  # (k,) int64
    found: Any  # (2, k) distance and cos ω of crossings that are not yet judged


@njit(**INNER)
def split(axes, size, a, b):  # type: ignore[no-untyped-def]
    """Start and direction of the sub-ray at offset (a, b); `size`: exit radius and spread."""
    o, d, left, up = axes
    offset = (a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2])
    return along(o, offset, size[0]), along(d, offset, size[1])


@njit(**INNER)
def localise(centre, frames, i, axes):  # type: ignore[no-untyped-def]
    """Origin, direction, left and up of a beam in the frame of a surface."""
    origin, d, left, up = axes
    o = turn_in(frames, i, minus(origin, centre))
    return o, turn_in(frames, i, d), turn_in(frames, i, left), turn_in(frames, i, up)


@njit(**INNER)
def keep_nearer(hits, ahead, index):  # type: ignore[no-untyped-def]
    """Take over the crossings found, `ahead` metres further on, that are the nearest so far."""
    distance, facing, surface = hits.distance, hits.facing, hits.surface
    t, cosine = hits.found[0], hits.found[1]
    for k in range(len(distance)):
        away = t[k] + ahead
        # Of surfaces that meet where a ray ends, the first counts, in whatever order they come.
        nearer = (away < distance[k]) | ((away == distance[k]) & (index < surface[k]))
        nearer = nearer & (away > 0.0)
        distance[k] = away if nearer else distance[k]
        facing[k] = min(cosine[k], 1.0) if nearer else facing[k]
        surface[k] = index if nearer else surface[k]
