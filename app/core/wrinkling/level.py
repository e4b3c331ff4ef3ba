"""The offset that makes a leaf agree with its own plane: only differences are left to claim."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.wrinkling.curve import KnownCurve
from app.core.wrinkling.offset import Offset

QUANTILES = 401
TABLE = 2001
STEPS = 80
LEAST = 10


def level_leaf(
    intensity: Floats,
    curve: KnownCurve,
    omega_plane: float,
    sigma_plane: float = 0.0,
    steepest: float = np.pi / 3,
) -> Offset:
    """Offset with which the mean angle from intensity is the angle of the leaf's plane.

    Points that the offset puts beyond an end of the curve count with that end, so that the mean
    follows the offset without a jump, and one solution exists.

    Parameters
    ----------
    intensity : (n,) array
    curve : KnownCurve
    omega_plane, sigma_plane : float
        ω of the plane and its standard error, radians.
    steepest : float
        Planes steeper than this have no offset, radians.

    Returns
    -------
    Offset
        Its σ: what the error of the plane and that of the mean intensity come to.

    Raises
    ------
    BadInput
        Fewer than ten points, no plane, a plane beyond the limit or beside the curve.
    """
    known = intensity[np.isfinite(intensity)]
    if curve.scale == "linear":
        known = known[known > 0.0]
    if len(known) < LEAST:
        raise BadInput(
            f"An offset needs {LEAST} points with an intensity; the leaf has {len(known)}."
        )
    low, high = curve.monotone
    _check_plane(omega_plane, min(high, steepest), low)
    logs = np.quantile(_to_log(known, curve), np.linspace(0.0, 1.0, QUANTILES))
    angle = np.linspace(low, high, TABLE)
    value = curve.evaluate(angle)
    reached = value > 0.0 if curve.scale == "linear" else np.isfinite(value)
    angle, height = angle[reached], _to_log(value[reached], curve)
    order = np.argsort(height)
    shift = _bisect(logs, height[order], angle[order], omega_plane, curve.falls)
    sigma = _error(curve, omega_plane, sigma_plane, logs, len(known))
    if curve.scale == "log":
        return Offset("added", shift, sigma)
    return Offset("factor", float(np.exp(shift)), float(np.exp(shift)) * sigma)


def _check_plane(omega: float, high: float, low: float) -> None:
    if not np.isfinite(omega):
        raise BadInput("The leaf has no plane that an offset could be found from.")
    if not low < omega < high:
        raise BadInput(
            f"The leaf's plane is at {np.rad2deg(omega):.1f}°: an offset can be found between "
            f"{np.rad2deg(low):.1f}° and {np.rad2deg(high):.1f}° only.",
            "Choose a leaf that faces the scanner more, or a known offset.",
        )


def _to_log(values: Floats, curve: KnownCurve) -> Floats:
    return np.asarray(np.log(values) if curve.scale == "linear" else values, np.float64)


def _bisect(logs: Floats, height: Floats, angle: Floats, wanted: float, falls: bool) -> float:
    low, high = float(logs.min() - height[-1]), float(logs.max() - height[0])
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        mean = float(np.interp(logs - middle, height, angle).mean())
        # A larger offset makes the leaf darker to the curve, which is steeper where it falls.
        if (mean < wanted) == falls:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _error(curve: KnownCurve, omega: float, sigma_plane: float, logs: Floats, count: int) -> float:
    """σ of a shift of the logarithm, or of DN."""
    here = np.array([omega])
    slope = abs(float(curve.slope(here)[0]))
    if curve.scale == "linear":
        slope /= float(curve.evaluate(here)[0])
    plane = sigma_plane if np.isfinite(sigma_plane) else 0.0
    return float(np.hypot(slope * plane, logs.std() / np.sqrt(count)))
