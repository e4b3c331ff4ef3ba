"""Normals from intensity: an angle leaves a cone about the beam, a plane picks the side.

Balduzzi 2011, 9. For steep parts, where ranges tell no plane.
"""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import WrongUse

SIDELESS = 1e-6
"""Sine of the angle between beam and plane normal below which a plane picks no side."""


def cone_normals(xyz: Floats, scanner: AnyArray, plane: Floats, omega: Floats) -> Floats:
    """Normals at an angle from the beam, nearest to that of a plane.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    plane : (n, 3) or (3,)
        Normals of the local planes, or of the leaf's plane; of any sign.
    omega : (n,) radians
        Angles of incidence from intensity.

    Returns
    -------
    (n, 3)
        Unit vectors towards the scanner. NaN where angle, point or plane are unknown, or where
        the plane faces the beam, so that all sides of the cone are alike; an angle of 0 needs
        no side.

    Raises
    ------
    WrongUse
        The arrays do not belong together.
    """
    points, angle = np.asarray(xyz, np.float64), np.asarray(omega, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or angle.shape != (len(points),):
        raise WrongUse("Points must be n × 3, and their angles n.")
    beam = np.asarray(scanner, np.float64) - points
    with np.errstate(divide="ignore", invalid="ignore"):
        beam /= np.linalg.norm(beam, axis=1, keepdims=True)
        given = np.broadcast_to(np.asarray(plane, np.float64), beam.shape)
        given = given / np.linalg.norm(given, axis=1, keepdims=True)
        facing = np.einsum("ij,ij->i", given, beam)
        given = np.where((facing < 0.0)[:, None], -given, given)
        side = given - np.abs(facing)[:, None] * beam
        size = np.linalg.norm(side, axis=1, keepdims=True)
        side = np.where(size > SIDELESS, side / size, np.nan)
        side = np.where((angle == 0.0)[:, None] & np.isfinite(beam), 0.0, side)
        known = (angle >= 0.0) & (angle <= np.pi / 2)
        normals = np.cos(angle)[:, None] * beam + np.sin(angle)[:, None] * side
    return np.where(known[:, None], normals, np.nan)
