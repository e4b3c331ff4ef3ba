"""Noise of a number, constant and in proportion, estimated from what a fit leaves over."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.panels import PanelTable
from app.core.radiometry.profile import ChannelCalibration, Noise

ROUNDS = 8
MIXES = np.linspace(-18.0, 18.0, 73)
"""ln of the part in proportion over the constant part, at the largest number."""
TINY = 1e-300


def noise_of_points(found: ChannelCalibration, table: PanelTable, scatter: Floats) -> Noise:
    """Noise of a point, from how the points of panels scatter (σ of a row's points, DN, (n,)).

    The powers of the scans do not matter: each number tells its own light.
    """
    away = found.hold(table.distance)
    light = chains.invert(found.steps, table.dn, away)
    echo = light * chains.linearise(found.steps, light, away).slope
    known = np.isfinite(echo)
    return estimate_point_noise(scatter[known], table.dn[known], echo[known])


def estimate_point_noise(scatter: Floats, number: Floats, echo: Floats) -> Noise:
    """Noise of single points, from how the points of panels scatter.

    Non-negative least squares of the variances, each weighted by its own, in turns.

    Parameters
    ----------
    scatter, number : (n,) arrays
        Standard deviation and mean of each panel's points, DN.
    echo : (n,) array
        Reflectance times the derivative of the number by it, DN; see `Noise.sigma`.
    """
    from scipy.optimize import nnls

    variance = scatter**2
    columns = np.stack([np.ones(len(number)), number**2, echo**2], axis=1)
    lengths = np.maximum(np.linalg.norm(columns, axis=0), TINY)
    fitted, parts = np.maximum(variance, TINY), np.zeros(3)
    for _ in range(ROUNDS):
        parts = nnls(columns / lengths / fitted[:, None], variance / fitted)[0] / lengths
        fitted = np.maximum(columns @ parts, TINY)
    return Noise(*map(float, np.sqrt(parts)))


def estimate_noise(residual: Floats, fitted: Floats, parameters: int) -> Noise:
    """The constant and the share of σ² = constant² + (share · DN)².

    Maximum likelihood for normal residuals: for each mix of the two parts the size follows at
    once, so that one number is sought. The squares are enlarged by n / (n − p), because a fit
    with p parameters comes nearer to its data than the truth does.

    Parameters
    ----------
    residual, fitted : (n,) arrays
        DN.
    parameters : int
        p.
    """
    from scipy.optimize import minimize_scalar

    largest = float(np.abs(fitted).max()) or 1.0
    size = (fitted / largest) ** 2
    enlarged = len(residual) / max(len(residual) - parameters, 1)
    square = residual**2 * enlarged

    def blend(mix: float) -> Floats:
        share = 1.0 / (1.0 + np.exp(-mix))
        return np.asarray((1.0 - share) + share * size)

    def cost(mix: float) -> float:
        shape = blend(mix)
        return float(np.log(np.mean(square / shape) + TINY) + np.mean(np.log(shape)))

    costs = [cost(mix) for mix in MIXES]
    at = int(np.argmin(costs))
    ends = MIXES[max(at - 1, 0)], MIXES[min(at + 1, len(MIXES) - 1)]
    mix = float(minimize_scalar(cost, bounds=ends, method="bounded").x)
    share = 1.0 / (1.0 + np.exp(-mix))
    variance = float(np.mean(square / blend(mix))) or (np.finfo(float).eps * largest) ** 2
    return Noise(float(np.sqrt(variance * (1 - share))), float(np.sqrt(variance * share)) / largest)
