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
            f"Only {len(known)} points of the leaf are hit wholly by the beam, and {LEAST} are "
            "needed.",
            "Scan it from nearer, or with a finer step.",
        )
    low, high = curve.monotone
    _check_plane(omega_plane, low, high, steepest)
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


def _check_plane(omega: float, low: float, high: float, steepest: float) -> None:
    if not np.isfinite(omega):
        raise BadInput("The leaf has no plane that an offset could be found from.")
    there = f"The leaf's plane stands at {np.rad2deg(omega):.1f}°"
    if not omega < steepest:
        raise BadInput(
            f"{there}: beyond {np.rad2deg(steepest):g}°, the steepest valid angle, intensity says "
            "too little of the angle.",
            "Scan it from where it faces the scanner more.",
        )
    if not low < omega < high:
        raise BadInput(
            f"{there}, and the curve can be read from {np.rad2deg(low):.1f}° to "
            f"{np.rad2deg(high):.1f}° only.",
            "Take a curve that reaches there (--curve or --species).",
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
