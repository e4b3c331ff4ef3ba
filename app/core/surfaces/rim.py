"""What the rim of a steep leaf may lose.

Across the beam the border of a leaf is known to a share of the beam's radius, whatever its angle.
On the leaf that share is longer by 1 / cos ω; and it errs to one side: where a leaf turns away, its
rim is darker than the rest and thinner than the beam, so that points there count as ghosts.
"""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats, Ints

STEEP = float(np.cos(np.deg2rad(60.0)))
"""Cosine of the angle from which on a rim may be lost."""
LOST = 0.5
"""Beam radii that it may lose."""
LEAST = 0.05
"""Cosines below are taken for this one."""


def estimate_lost(beams: Floats, faces: Ints, omega: Floats, radius: float) -> float:
    """Area that may be missing along steep parts of the border, square metres.

    Parameters
    ----------
    beams : (v, 3) metres
        Corners about the scanner.
    faces : (f, 3)
    omega : (f,) radians
    radius : float
        Metres: of the beam at the leaf.
    """
    length, cosine = list_rim(beams, faces, omega)
    steep = cosine < STEEP
    longer = 1.0 / np.maximum(cosine[steep], LEAST) - 1.0
    return LOST * radius * float((length[steep] * longer).sum())


def list_rim(beams: Floats, faces: Ints, omega: Floats) -> tuple[Floats, Floats]:
    """Sides that belong to one triangle only: their lengths across the beam, and cos ω there."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    low, high = np.sort(sides, axis=1).T
    _, place, count = np.unique(low * len(beams) + high, return_inverse=True, return_counts=True)
    rim = count[place] == 1
    one, other = beams[sides[rim, 0]], beams[sides[rim, 1]]
    ahead = one + other
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    along = other - one
    along -= (along * ahead).sum(axis=1)[:, None] * ahead
    return np.linalg.norm(along, axis=1), np.cos(omega[owner[rim]])
