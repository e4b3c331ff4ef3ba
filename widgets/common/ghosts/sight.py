"""How a single ghost is looked at: from the side of its beam, with lines that point it out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Bools, Floats
from app.render.camera import Camera

VIEWS = ((50, 20), (-50, 20), (50, -15), (-50, -15), (30, 15), (-30, 15), (12, 6), (-12, 6), (0, 0))
"""Degrees to the right of the beam and above it, the best to tell ranges first; the last is the
scanner's own view, in which its beam met nothing on the way."""
VISIBLE = 0.12
"""Half-width of the way to a ghost that should be free, as a share of what is seen around it."""
LONGEST_WAY = 8.0
"""From the viewer to a ghost, in the same shares: that of an angle of view of 30°."""
TURNED = np.deg2rad(0.5)
CLOSEST, FARTHEST = 0.03, 0.20
"""Metres: half of what is seen around a ghost."""
PER_SHIFT, PER_RANGE = 2.5, 0.008
CORNERS = 24
RING = 0.06
"""Radius of the ring around a ghost, as a share of what is seen."""
MOST_ARROWS, LONGEST_ARROW = 5000, 0.06
"""Lines of moves, and metres: what goes farther, to a wall, would hide everything."""


def reach_around(point: Floats, scanner: Floats, shift: float) -> float:
    """Metres around a ghost that show what it lies between."""
    away = float(np.linalg.norm(point - scanner))
    wanted = max(PER_SHIFT * abs(shift), PER_RANGE * away)
    return min(max(wanted, CLOSEST), FARTHEST)


def look_across(
    camera: Camera, point: Floats, scanner: Floats, view: tuple[float, float] = VIEWS[0]
) -> Camera:
    """A camera that sees a point obliquely to its beam, which then runs across the picture.

    `view` are degrees to the right of the beam and above it.
    """
    aside, above = np.deg2rad(view)
    beam = _unit(point - scanner)
    up = np.array([0.0, 0.0, 1.0]) if abs(beam[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    right = _unit(np.cross(beam, up))
    high = np.cross(right, beam)
    level = np.cos(aside) * beam + np.sin(aside) * right
    forward = np.cos(above) * level - np.sin(above) * high
    place = point - forward
    x, y, z = (float(value) for value in place)
    a, b, c = (float(value) for value in point)
    i, j, k = (float(value) for value in up)
    return replace(camera, position=(x, y, z), focal_point=(a, b, c), view_up=(i, j, k))


def choose_view(
    camera: Camera, xyz: Floats, alive: Bools, point: Floats, scanner: Floats, reach: float
) -> Camera:
    """Of the views across the beam the first from which nothing hides the point, else the freest.

    Parameters
    ----------
    camera : Camera
        As it is; what it does not share with the views stays.
    xyz : (n, 3) metres
    alive : (n,) bool
        Points that are drawn.
    point, scanner : (3,) metres
    reach : float
        Metres around the point that will be seen.
    """
    near = alive.copy()
    for axis in range(3):
        near &= np.abs(xyz[:, axis] - point[axis]) < LONGEST_WAY * reach
    around = xyz[near] - point
    views = [look_across(camera, point, scanner, view) for view in VIEWS]
    hidden = [count_hiding(view, around, VISIBLE * reach) for view in views]
    return views[int(np.argmin(hidden))]


def count_hiding(camera: Camera, around: Floats, width: float) -> int:
    """How many points, given from the focal point on, stand within `width` of the way to it.

    Those beside the focal point, on both sides of it, hide nothing.
    """
    forward = camera.axes()[2]
    depth = around @ forward
    before = depth < -1.5 * width
    off = np.linalg.norm(around[before] - depth[before, None] * forward, axis=1)
    # The way narrows towards the viewer.
    free = width * np.clip(1.0 + depth[before] / (LONGEST_WAY * width / VISIBLE), 0.0, 1.0)
    return int(np.count_nonzero(off < free))


def is_turned(camera: Camera, since: Camera) -> bool:
    """Whether somebody looks from another direction since then."""
    now, then = (np.stack(each.axes()) for each in (camera, since))
    cosines = np.einsum("ij,ij->i", now, then)
    return bool((cosines < np.cos(TURNED)).any())


def corners_around(point: Floats, reach: float) -> Floats:
    """Points that a view has to show, (8, 3) metres."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    corners: Floats = point + reach * signs
    return corners


def mark_ghost(point: Floats, scanner: Floats, reach: float, shift: float) -> Floats:
    """Lines that point a ghost out, (3, CORNERS, 3): its beam, a ring, and where it would go."""
    beam = _unit(point - scanner)
    up = np.array([0.0, 0.0, 1.0]) if abs(beam[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    right = _unit(np.cross(beam, up))
    high = np.cross(right, beam)
    turn = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)[:, None]
    ring = RING * reach * (np.cos(turn) * right + np.sin(turn) * high)
    line = np.linspace(-reach, reach, CORNERS)[:, None] * beam
    target = shift * beam + (0.6 * ring if shift else 0.0 * ring)
    lines: Floats = point + np.stack([line, ring, target])
    return lines


def mark_moves(before: Floats, after: Floats) -> Floats:
    """Lines from where points are to where they would go, (k, 2, 3); a share when they are many."""
    short = np.linalg.norm(after - before, axis=1) <= LONGEST_ARROW
    before, after = before[short], after[short]
    step = max(1, -(-len(before) // MOST_ARROWS))
    return np.stack([before[::step], after[::step]], axis=1)


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / np.linalg.norm(vector)
    return unit
