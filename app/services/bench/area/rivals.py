"""Areas as they are made elsewhere: Delaunay and convex hull in the leaf's plane, and SOR."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats

NEIGHBOURS, SIGMAS = 8, 2.0
"""Statistical outlier removal as usual: mean distance to 8 neighbours, mean + 2 σ."""
LONGEST = 4.0
"""Longest side of a triangle, in median sides, that Delaunay keeps."""


def keep_inliers(xyz: Floats) -> Bools:
    """Points that statistical outlier removal keeps, (n,)."""
    from scipy.spatial import cKDTree

    apart = np.asarray(cKDTree(xyz).query(xyz, NEIGHBOURS + 1, workers=-1)[0])
    away = apart[:, 1:].mean(axis=1)
    kept: Bools = away <= away.mean() + SIGMAS * away.std()
    return kept


def hull_area(xyz: Floats) -> float:
    """Convex hull in the plane of total least squares, square metres."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(_flatten(xyz)).volume)
    except QhullError:
        return float("nan")


def delaunay_area(xyz: Floats) -> float:
    """Delaunay triangles in that plane, lifted to the points, without long ones."""
    from scipy.spatial import Delaunay, QhullError

    flat = _flatten(xyz)
    try:
        corners = Delaunay(flat).simplices
    except QhullError:
        return float("nan")
    longest = np.linalg.norm(flat[corners] - flat[np.roll(corners, 1, axis=1)], axis=2).max(axis=1)
    corners = corners[longest <= LONGEST * np.median(longest)]
    one, two = xyz[corners[:, 1]] - xyz[corners[:, 0]], xyz[corners[:, 2]] - xyz[corners[:, 0]]
    return float(0.5 * np.linalg.norm(np.cross(one, two), axis=1).sum())


def _flatten(xyz: Floats) -> Floats:
    off = xyz - xyz.mean(axis=0)
    axes = np.linalg.svd(off, full_matrices=False)[2]
    return np.asarray(off @ axes[:2].T)
