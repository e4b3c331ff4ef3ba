"""Laser power of a new scan from panels of known reflectance in it (drift), with its σ."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.profile import ChannelCalibration, Noise

ROUNDS = 3


class PowerFound(NamedTuple):
    """Power of a scan, its σ, and its derivative by the parameters of the chain, (k,)."""

    power: float
    sigma: float
    pull: Floats


def measure_power(
    calibration: ChannelCalibration,
    number: Floats,
    distance: Floats,
    reflectance: Floats,
    reflectance_sigma: Floats | float = 0.0,
    number_sigma: Floats | None = None,
) -> PowerFound:
    """Power of a scan as a share of that of the reference scan.

    Each panel, or each of its points, gives a power: the light that its number tells over its
    reflectance. Their weighted mean is taken.

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
    PowerFound
        σ is NaN where no noise is known; `pull` tells what errors of the calibration do to it.

    Raises
    ------
    BadInput
        No panel gives a power.
    """
    steps = chains.with_power(calibration.steps, 1.0)
    light = np.where(_usable(calibration, number), chains.invert(steps, number, distance), np.nan)
    known = np.isfinite(light) & (light > 0)
    if not known.any():
        why = "Its numbers are dark, saturated or outside the calibration."
        raise BadInput("No panel of this scan gives a laser power.", why)
    dn, rho = number[known], reflectance[known]
    away = np.broadcast_to(distance, known.shape)[known]
    rho_share = np.broadcast_to(reflectance_sigma, known.shape)[known] / rho
    own = calibration.noise or Noise(1.0)
    given = None if number_sigma is None else number_sigma[known]
    power, sigma, pull = float(np.median(light[known] / rho)), np.inf, np.empty(0)
    for _ in range(ROUNDS):
        each = chains.linearise(steps, rho * power, away)
        noise = given if given is not None else own.sigma(each.value, each.slope * rho * power)
        variance = (noise / each.slope / rho) ** 2 + (power * rho_share) ** 2
        weight = 1.0 / np.maximum(variance, np.finfo(float).tiny)
        # A step of Gauss–Newton in the number: the light of a bright panel is a skew variable.
        apart = np.clip((dn - each.value) / each.slope / rho, -power / 2, power)
        power += float(np.sum(weight * apart) / np.sum(weight))
        sigma = float(np.sqrt(1.0 / np.sum(weight)))
        pull = -(each.gradient / each.slope / rho) @ (weight / np.sum(weight))
    unknown = calibration.noise is None and number_sigma is None
    return PowerFound(power, float("nan") if unknown else sigma, pull)


def _usable(calibration: ChannelCalibration, number: Floats) -> Bools:
    dark, saturated = _or(calibration.dark, -np.inf), _or(calibration.saturated, np.inf)
    return np.asarray(np.isfinite(number) & (number > dark) & (number < saturated))


def _or(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value
