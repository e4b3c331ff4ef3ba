"""Laser power of a new scan from panels of known reflectance in it (drift), with its σ."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.profile import ChannelCalibration, Noise

ROUNDS = 3


def measure_power(
    calibration: ChannelCalibration,
    number: Floats,
    distance: Floats,
    reflectance: Floats,
    reflectance_sigma: Floats | float = 0.0,
    number_sigma: Floats | None = None,
) -> tuple[float, float]:
    """Power of a scan as a share of that of the reference scan.

    Each panel gives a power, the light that its number tells over its reflectance; their
    weighted mean is taken.

    Parameters
    ----------
    calibration : ChannelCalibration
    number, distance, reflectance : (n,) arrays
        Of the panels.
    reflectance_sigma : (n,) array or float
    number_sigma : (n,) array, optional
        σ of the numbers; default: the noise of the channel. Give the σ of the mean for means.

    Returns
    -------
    power, sigma : float
        σ from the numbers and the reflectances, NaN where no noise is known; that of the
        calibration comes with the profile.

    Raises
    ------
    BadInput
        No panel gives a power.
    """
    steps = chains.with_power(calibration.steps, 1.0)
    light = np.where(_usable(calibration, number), chains.invert(steps, number, distance), np.nan)
    known = np.isfinite(light) & (light > 0)
    if not known.any():
        raise BadInput(
            "No panel of this scan gives a laser power.",
            "Its numbers are dark, saturated or outside the calibration.",
        )
    dn, rho = number[known], reflectance[known]
    away = np.broadcast_to(distance, known.shape)[known]
    rho_share = np.broadcast_to(reflectance_sigma, known.shape)[known] / rho
    own = calibration.noise or Noise(1.0)
    power, sigma = float(np.median(light[known] / rho)), np.inf
    for _ in range(ROUNDS):
        each = chains.linearise(steps, rho * power, away)
        noise = own.sigma(each.value) if number_sigma is None else number_sigma[known]
        variance = (noise / each.slope / rho) ** 2 + (power * rho_share) ** 2
        weight = 1.0 / np.maximum(variance, np.finfo(float).tiny)
        # A step of Gauss–Newton in the number: the light of a bright panel is a skew variable.
        apart = np.clip((dn - each.value) / each.slope / rho, -power / 2, power)
        power += float(np.sum(weight * apart) / np.sum(weight))
        sigma = float(np.sqrt(1.0 / np.sum(weight)))
    unknown = calibration.noise is None and number_sigma is None
    return power, float("nan") if unknown else sigma


def _usable(calibration: ChannelCalibration, number: Floats) -> Bools:
    dark, saturated = _or(calibration.dark, -np.inf), _or(calibration.saturated, np.inf)
    return np.asarray(np.isfinite(number) & (number > dark) & (number < saturated))


def _or(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value
