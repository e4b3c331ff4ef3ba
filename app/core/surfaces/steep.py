"""Steep parts of a mesh by intensity: what ranges tell badly there, brightness may tell.

Smoothing takes the slopes of short waves. Intensity gives the angle of each beam, the mesh the
side to which the leaf leans (Balduzzi 2011, 9). It helps on wrinkled leaves; flat and bent ones
are told better by ranges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.intensity_normals import cone_normals
from app.core.mesh import Mesh

STEEP = float(np.deg2rad(60.0))
"""Angle of a face from which on intensity is asked."""
NEAR = 3.0
"""Sides of a face up to which the nearest point with an angle speaks for it."""


def turn_steep(mesh: Mesh, xyz: Floats, members: Ints, scanner: AnyArray, omega: Floats) -> Mesh:
    """Give steep faces the angle that intensity tells, and normals to all.

    Corners and area stay as they are: on simulated leaves areas by intensity are worse than those
    by ranges (error of 90 % of the leaves 19 % against 11 %), by the reflectance of each leaf.

    Parameters
    ----------
    mesh : Mesh
    xyz : (n, 3) metres
    members : (k,)
        Points of the leaf.
    scanner : (3,) metres
    omega : (n,) radians
        Angles from intensity; NaN where there is none.
    """
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(across, axis=1)
    normals = across / np.where(double > 0.0, double, 1.0)[:, None]
    steep = np.flatnonzero(mesh.omega > STEEP)
    told = members[np.isfinite(omega[members]) & np.isfinite(xyz[members]).all(axis=1)]
    if not len(steep) or not len(told):
        return replace(mesh, normals=normals)
    centre = corners[steep].mean(axis=1)
    giver, near = _find_givers(centre, np.sqrt(double[steep]), xyz[told])
    steep, centre, giver = steep[near], centre[near], told[giver[near]]
    turned = cone_normals(centre, scanner, normals[steep], omega[giver])
    known = np.isfinite(turned).all(axis=1)
    normals[steep[known]] = turned[known]
    angle = mesh.omega.copy()
    angle[steep[known]] = omega[giver[known]]
    return replace(mesh, omega=angle, normals=normals)


def _find_givers(centre: Floats, side: Floats, points: Floats) -> tuple[Ints, Bools]:
    from scipy.spatial import cKDTree

    away, giver = cKDTree(points).query(centre)
    return np.asarray(giver), np.asarray(away <= NEAR * side)
