"""How sure a reflectance is, and what makes it unsure: noise, fit, panels, power, range."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from app.core.arrays import Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.profile import ChannelCalibration

PARTS = ("noise", "fit", "panels", "power", "range")
_AT_ONCE = 20_000  # points: the gradients of many parameters are large


class Budget(NamedTuple):
    """Standard deviations of reflectances, by cause; (n,) arrays.

    Attributes
    ----------
    noise : of the number itself
    fit : of the parameters, from the noise of the panels' numbers
    panels : of the parameters, from the reflectances of the panels
    power : of the laser power of the scan
    range : of the distance
    """

    noise: Floats
    fit: Floats
    panels: Floats
    power: Floats
    range: Floats

    @property
    def sigma(self) -> Floats:
        """All together, (n,)."""
        return np.asarray(np.sqrt(sum(part**2 for part in self)))


def error_budget(
    calibration: ChannelCalibration,
    reflectance: Floats,
    number: Floats,
    distance: Floats,
    power: float = 1.0,
    power_sigma: float = 0.0,
    power_pull: Floats | None = None,
) -> Budget:
    """σ of each reflectance, by linear propagation through the chain; NaN for unknown parts.

    The number is F(ρ, d; θ), so that dρ = (dDN − F_θ·dθ − F_d·dd) / F_ρ.

    Parameters
    ----------
    calibration : ChannelCalibration
    reflectance : (n,) array
        As the chain gave it; NaN gives NaN.
    number : (n,) array
        What was measured, for its noise.
    distance : (n,) array
        Metres.
    power, power_sigma : float
        Laser power of the scan and its σ.
    power_pull : (k,) array, optional
        Derivative of the power by the parameters of the chain, where it was measured with this
        calibration (`power.measure_power`): errors that panel and target share cancel.
    """
    pieces = max(1, -(-len(reflectance) // _AT_ONCE))
    rows = np.array_split(np.arange(len(reflectance)), pieces)
    distance = np.broadcast_to(np.asarray(distance, float), reflectance.shape)
    budgets = [
        _propagate(
            calibration, reflectance[r], number[r], distance[r], power, power_sigma, power_pull
        )
        for r in rows
    ]
    return Budget(*(np.concatenate(part) for part in zip(*budgets, strict=True)))


def mean_budget(
    calibration: ChannelCalibration,
    reflectance: Floats,
    number: Floats,
    distance: Floats,
    power: float = 1.0,
    power_sigma: float = 0.0,
    power_pull: Floats | None = None,
) -> Budget:
    """Budget of the mean reflectance of points, one value per part, (1,) arrays.

    Noise and range errors of points average out; fit, panels and power are the same error in
    all of them. Points without a reflectance are left out; with none, all parts are NaN.
    """
    known = np.isfinite(reflectance)
    if not known.any():
        return Budget(*(np.full(1, np.nan) for _ in PARTS))
    distance = np.broadcast_to(np.asarray(distance, float), reflectance.shape)[known]
    rho, count = reflectance[known], int(known.sum())
    each = _derive(calibration, rho, distance, power)
    by_parameter = _pull(each, rho, power, power_pull).mean(axis=1)
    alone = error_budget(calibration, rho, number[known], distance, power, power_sigma)
    return Budget(
        np.sqrt(np.sum(alone.noise**2, keepdims=True)) / count,
        _project(calibration.covariance("fit"), by_parameter[:, None]),
        _project(calibration.covariance("panel"), by_parameter[:, None]),
        np.abs(np.mean(rho / power, keepdims=True)) * power_sigma,
        np.sqrt(np.sum(alone.range**2, keepdims=True)) / count,
    )


def _propagate(
    calibration: ChannelCalibration,
    reflectance: Floats,
    number: Floats,
    distance: Floats,
    power: float,
    power_sigma: float,
    power_pull: Floats | None,
) -> Budget:
    each = _derive(calibration, reflectance, distance, power)
    by_parameter = _pull(each, reflectance, power, power_pull)
    unknown = np.where(np.isfinite(reflectance), 0.0, np.nan)
    echo = reflectance * each.slope
    noise = calibration.noise.sigma(number, echo) if calibration.noise else np.nan
    return Budget(
        noise / np.abs(each.slope) + unknown,
        _project(calibration.covariance("fit"), by_parameter) + unknown,
        _project(calibration.covariance("panel"), by_parameter) + unknown,
        np.abs(reflectance) / power * power_sigma,
        np.abs(each.range_slope / each.slope) * calibration.range_sigma + unknown,
    )


def _derive(
    calibration: ChannelCalibration, reflectance: Floats, distance: Floats, power: float
) -> chains.Linearised:
    steps = chains.with_power(calibration.steps, power)
    return chains.linearise(steps, reflectance, calibration.hold(distance))


def _pull(
    each: chains.Linearised, reflectance: Floats, power: float, power_pull: Floats | None
) -> Floats:
    """Derivative of a reflectance by the parameters, but for its sign, (k, n)."""
    direct = each.gradient / each.slope
    return direct if power_pull is None else direct + np.outer(power_pull, reflectance) / power


def _project(covariance: Floats, gradient: Floats) -> Floats:
    """√(gᵀ C g) for each column of a (k, n) gradient."""
    variance = np.einsum("kn,kl,ln->n", gradient, covariance, gradient, optimize=True)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
