"""Scraps of a wall that show between leaves: small surfaces in the plane of a large one."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats, Ints

MOST_WALLS, FEWEST, LOOKED_AT = 8, 1000, 3000
"""Large surfaces that are looked at, the points that each has at least, and those fitted."""
ROUNDS, SIGMAS = 5, 3.0
PLANE = 0.6
"""Share of a large surface that lies in its plane; ground and trunks have none."""
NEAR, NOISES = 0.003, 2.0
"""Metres, and σ of the range, within which a scrap lies of the plane (root mean square)."""


def find_scraps(xyz: Floats, label: Ints, large: Bools, noise: float) -> Bools:
    """Which small surfaces lie in the plane of a large, flat one.

    A leaf that lies flat on a wall cannot be told from it either.

    Parameters
    ----------
    xyz : (n, 3) metres
    label : (n,)
        Number of each point's surface, from 0; -1 for none.
    large : (n,) bool
        Points of surfaces too large for a leaf, each labelled.
    noise : float
        Metres: σ of a range.

    Returns
    -------
    (label.max() + 1,) bool
        False for the large surfaces.
    """
    total = int(label.max(initial=-1)) + 1
    size = np.bincount(label[label >= 0], minlength=total)
    # One more than there are surfaces: the last stands for points of none.
    is_large = np.zeros(total + 1, np.bool_)
    is_large[label[large & (label >= 0)]] = True
    walls = np.flatnonzero(is_large[:-1] & (size >= FEWEST))
    walls = walls[np.argsort(-size[walls])][:MOST_WALLS]
    small = np.flatnonzero((label >= 0) & ~is_large[label])
    near = max(NEAR, NOISES * noise)
    scrap = np.zeros(total, np.bool_)
    for wall in walls:
        plane = _fit_plane(xyz[label == wall], near)
        if plane is not None:
            off = (xyz[small] - plane[0]) @ plane[1]
            square = np.bincount(label[small], off**2, minlength=total)
            scrap |= (square <= size * near**2) & (size > 0) & ~is_large[:-1]
    return scrap


def _fit_plane(points: Floats, near: float) -> tuple[Floats, Floats] | None:
    """A point and the normal of the plane that most of the points lie in, or None."""
    some = points[:: max(1, len(points) // LOOKED_AT)]
    kept = np.ones(len(some), np.bool_)
    for _ in range(ROUNDS):
        middle = some[kept].mean(axis=0)
        normal = np.linalg.eigh((some[kept] - middle).T @ (some[kept] - middle))[1][:, 0]
        off = np.abs((some - middle) @ normal)
        kept = off <= max(SIGMAS * float(np.median(off)), near)
    return (middle, normal) if np.mean(off <= SIGMAS * near) >= PLANE else None
