"""Size of the beam on a leaf (Balduzzi 2011, equation 4), and size of the leaf."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from app.core.arrays import Floats, finite_rows
from app.core.errors import WrongUse


class BeamShape(NamedTuple):
    """Radius of a beam at the aperture, metres, and half of its full divergence, radians."""

    radius: float
    half_divergence: float


def footprint_axis(
    distance: npt.ArrayLike,
    incidence: npt.ArrayLike,
    beam_radius: float,
    half_divergence: float,
) -> Floats:
    """Major axis of the beam's footprint on a plane.

    Parameters
    ----------
    distance : array_like
        Range, metres.
    incidence : array_like
        Incidence angle, radians; broadcast against `distance`.
    beam_radius : float
        Radius of the beam at the aperture, metres (half of the exit diameter).
    half_divergence : float
        Half of the full divergence, radians.

    Returns
    -------
    array
        D = 2 (r₀ + d tan δ) / (cos ω (1 − tan²ω tan²δ)), metres; inf where the beam's outer
        ray no longer meets the plane (ω ≥ π/2 − δ); NaN where distance or angle are unknown,
        or the distance is negative.

    Raises
    ------
    WrongUse
        A negative radius, or a divergence outside 0 to π/4.
    """
    check_beam(beam_radius, half_divergence)
    d, angle = np.broadcast_arrays(
        np.asarray(distance, dtype=np.float64), np.asarray(incidence, dtype=np.float64)
    )
    beam = 2.0 * (beam_radius + d * np.tan(half_divergence))
    with np.errstate(divide="ignore", invalid="ignore"):
        stretch = np.cos(angle) * (1.0 - (np.tan(angle) * np.tan(half_divergence)) ** 2)
        meets = np.abs(angle) < np.pi / 2 - half_divergence
        axis: Floats = np.where(meets, beam / stretch, np.inf)
    return np.where(np.isnan(angle) | ~(d >= 0.0), np.nan, axis)


def check_beam(beam_radius: float, half_divergence: float) -> None:
    """Refuse (`WrongUse`) a negative radius, or a half divergence outside 0 to π/4."""
    if not (0.0 <= beam_radius < np.inf and 0.0 <= half_divergence < np.pi / 4):
        raise WrongUse(
            "A beam needs a radius from 0 m and a half divergence from 0 to 45 degrees.",
            "Check whether the divergence is a full or a half angle.",
        )


def leaf_diameter(xyz: Floats, normal: Floats) -> float:
    """Diameter of the circle that has the area of a leaf.

    The area is that of the convex hull of the points as seen along the normal: it needs no
    grid and no step between beams. What a lobed leaf leaves open counts as leaf.

    Parameters
    ----------
    xyz : (k, 3) metres
        Rows that are not finite are left out.
    normal : (3,)
        Unit normal of the leaf's plane.

    Returns
    -------
    float
        Metres; NaN where the points span no area.
    """
    from scipy.spatial import ConvexHull, QhullError

    known = xyz[finite_rows(xyz)]
    if len(known) < 3:
        return float("nan")
    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    across /= np.linalg.norm(across)
    flat = (known - known.mean(axis=0)) @ np.stack([across, np.cross(normal, across)], axis=1)
    try:
        area = ConvexHull(flat).volume  # in the plane, qhull's volume is the area
    except QhullError:
        return float("nan")
    return float(2.0 * np.sqrt(area / np.pi))
