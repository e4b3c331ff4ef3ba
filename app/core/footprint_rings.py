"""The border of the beam's footprint on the plane at a point, as a closed line in space."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.core.footprint import check_beam

CORNERS = 36


def footprint_rings(
    xyz: Floats,
    normals: Floats,
    scanner: Floats,
    beam_radius: float,
    half_divergence: float,
    corners: int = CORNERS,
) -> Floats:
    """Where the outer rays of beams meet the planes at points.

    The rays leave a disc of the beam's radius and spread by the half divergence, as in
    Balduzzi's equation 4: the longest diameter of a ring is `footprint_axis`.

    Parameters
    ----------
    xyz, normals : (k, 3) arrays
        Points, metres, and unit normals of the planes there (to either side).
    scanner : (3,) array
        Metres.
    beam_radius, half_divergence : float
        Metres at the aperture; radians, half angle.
    corners : int

    Returns
    -------
    (k, corners, 3) array
        World metres; NaN where the normal is unknown, or a ray does not meet the plane.

    Raises
    ------
    WrongUse
        See `check_beam`.
    """
    check_beam(beam_radius, half_divergence)
    away = xyz - scanner
    with np.errstate(invalid="ignore", divide="ignore"):
        beam = away / np.linalg.norm(away, axis=1, keepdims=True)
    side, up = _span(beam)
    turn = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    out = np.cos(turn)[None, :, None] * side[:, None, :] + np.sin(turn)[None, :, None] * up[:, None]
    start = beam_radius * out
    ray = beam[:, None, :] + np.tan(half_divergence) * out
    facing = np.einsum("kci,ki->kc", ray, normals)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.einsum("kci,ki->kc", away[:, None, :] - start, normals) / facing
    meets = (along > 0.0).all(axis=1) & np.isfinite(along).all(axis=1)
    rings: Floats = scanner + start + along[:, :, None] * ray
    return np.where(meets[:, None, None], rings, np.nan)


def _span(beam: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors across each beam, square to each other."""
    across = np.zeros_like(beam)
    across[np.arange(len(beam)), np.argmin(np.abs(np.nan_to_num(beam)), axis=1)] = 1.0
    side = np.cross(beam, across)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return side, np.cross(beam, side)
