"""How a single ghost is looked at: from the side of its beam, with lines that point it out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.render.camera import Camera

ASIDE, ABOVE = np.deg2rad(50.0), np.deg2rad(20.0)
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


def look_across(camera: Camera, point: Floats, scanner: Floats) -> Camera:
    """A camera that sees a point obliquely to its beam, which then runs across the picture."""
    beam = _unit(point - scanner)
    up = np.array([0.0, 0.0, 1.0]) if abs(beam[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    right = _unit(np.cross(beam, up))
    high = np.cross(right, beam)
    level = np.cos(ASIDE) * beam + np.sin(ASIDE) * right
    forward = np.cos(ABOVE) * level - np.sin(ABOVE) * high
    place = point - forward
    x, y, z = (float(value) for value in place)
    a, b, c = (float(value) for value in point)
    i, j, k = (float(value) for value in up)
    return replace(camera, position=(x, y, z), focal_point=(a, b, c), view_up=(i, j, k))


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
