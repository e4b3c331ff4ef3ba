"""From intensity to angle: a fitted curve read backwards, with its error and its doubts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntFlag

import numpy as np

from app.core.arrays import AnyArray, Floats

EDGE_ON = np.pi / 2
# Beyond 60° intensity says little about angle (Balduzzi 2011, section 4; science.md 5).
TRUSTED_TO = np.pi / 3
# ±10 to ±15° is what the paper reaches on the tree: an error above that is no measurement.
LARGEST_SIGMA = np.deg2rad(15.0)
_STEP = 1e-4


@dataclass(frozen=True, slots=True)
class Curve:
    """A fitted I(ω) as two or three callables on arrays; angles in radians.

    Attributes
    ----------
    evaluate : angle -> intensity
    inverse : intensity -> angle
        NaN outside the range of the curve.
    derivative : angle -> dI/dω, or None
        None: central differences of `evaluate`.
    """

    evaluate: Callable[[Floats], Floats]
    inverse: Callable[[Floats], Floats]
    derivative: Callable[[Floats], Floats] | None = None


class Doubt(IntFlag):
    """Why an angle from intensity is not to be trusted."""

    NONE = 0
    OUTSIDE = 1
    BEYOND = 2
    FLAT = 4


@dataclass(frozen=True, slots=True, eq=False)
class IntensityAngles:
    """Angles from intensity, with their error and their doubts.

    Attributes
    ----------
    omega : (n,) radians
        NaN where the intensity is outside the curve.
    sigma : (n,) radians
        Infinite where the curve is level, NaN where `omega` is.
    doubt : (n,) uint8
        Sum of `Doubt` flags: OUTSIDE the curve, BEYOND 60°, curve too FLAT for the noise.
    """

    omega: Floats
    sigma: Floats
    doubt: AnyArray


def invert_intensity(
    intensity: Floats,
    sigma_intensity: Floats | float,
    curve: Curve,
    trusted_to: float = TRUSTED_TO,
    largest_sigma: float = LARGEST_SIGMA,
) -> IntensityAngles:
    """Incidence angle of every point from its corrected intensity.

    Parameters
    ----------
    intensity : (n,) array
    sigma_intensity : float or (n,) array
        Standard deviation, in the unit of the intensity.
    curve : Curve
    trusted_to : float
        Angles beyond it are flagged, in radians.
    largest_sigma : float
        Angles less certain than this are flagged, in radians.

    Returns
    -------
    IntensityAngles
        Doubtful angles keep their values; a map must show the doubt.
    """
    values = np.asarray(intensity, dtype=np.float64)
    omega = np.asarray(curve.inverse(values), dtype=np.float64)
    sigma = sigma_omega(omega, sigma_intensity, curve)
    outside = np.isnan(omega)
    flat = ~outside & ~(sigma <= largest_sigma)
    doubt = outside * Doubt.OUTSIDE | (omega > trusted_to) * Doubt.BEYOND | flat * Doubt.FLAT
    return IntensityAngles(omega, sigma, doubt.astype(np.uint8))


def sigma_omega(omega: Floats, sigma_intensity: Floats | float, curve: Curve) -> Floats:
    """Error of an angle from intensity, σ_ω = σ_I / |dI/dω|, in radians.

    Parameters
    ----------
    omega : (n,) radians
    sigma_intensity : float or (n,) array
    curve : Curve

    Returns
    -------
    (n,) array
        Infinite where the curve is level (at ω = 0 for all physical models).
    """
    slope = curve.derivative or (lambda angle: _difference(curve.evaluate, angle))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(sigma_intensity / np.abs(slope(omega)), dtype=np.float64)


def _difference(evaluate: Callable[[Floats], Floats], omega: Floats) -> Floats:
    # One-sided at the ends: a model need not be defined below 0° or beyond 90°.
    low, high = np.maximum(omega - _STEP, 0.0), np.minimum(omega + _STEP, EDGE_ON)
    slope: Floats = (evaluate(high) - evaluate(low)) / (high - low)
    return slope
