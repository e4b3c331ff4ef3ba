"""Steps in a row: from light to number and back, with all derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from app.core.arrays import Floats
from app.core.radiometry.drift import Power
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.range_curve import PolynomialCurve, RangeCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.step import Step

AnyStep = (
    InverseSquare
    | AnalyticRange
    | PolynomialCurve
    | SplineCurve
    | Power
    | LogResponse
    | Decibel
    | LinearResponse
    | Proportional
    | SalcaResponse
)
RESPONSES = (LogResponse, LinearResponse, Proportional, SalcaResponse)
RANGE_EFFECTS = (InverseSquare, AnalyticRange, PolynomialCurve, SplineCurve)
Chain = Sequence[Step]


class Linearised(NamedTuple):
    """A chain near given reflectances.

    Attributes
    ----------
    value : (n,) array
        The number that the instrument gives.
    slope : (n,) array
        Its derivative by the reflectance.
    gradient : (k, n) array
        Its derivative by each free parameter, in the order of `names`.
    range_slope : (n,) array
        Its derivative by the distance, per metre.
    """

    value: Floats
    slope: Floats
    gradient: Floats
    range_slope: Floats


def names(chain: Chain) -> tuple[str, ...]:
    """Free parameters of all steps, in order."""
    return tuple(name for step in chain for name in step.names)


def values(chain: Chain) -> Floats:
    """Values of the free parameters, (k,)."""
    return np.concatenate([np.empty(0), *(step.values() for step in chain)])


def with_values(chain: Chain, new: Floats) -> tuple[Step, ...]:
    """The same chain with other values of its free parameters, (k,)."""
    steps, start = [], 0
    for step in chain:
        end = start + len(step.names)
        steps.append(step.with_values(new[start:end]) if end > start else step)
        start = end
    return tuple(steps)


def with_power(chain: Chain, power: float) -> tuple[Step, ...]:
    """The same chain for a scan with another laser power; a chain without one stays."""
    return tuple(Power(power) if isinstance(step, Power) else step for step in chain)


def needs_range(chain: Chain) -> bool:
    """Whether a step depends on the distance."""
    return any(isinstance(step, RANGE_EFFECTS) for step in chain)


def known_ranges(chain: Chain) -> tuple[float, float]:
    """Between which distances all steps are known, metres."""
    low, high = 0.0, np.inf
    for step in chain:
        if isinstance(step, AnalyticRange):
            low, high = max(low, step.nearest), min(high, step.farthest)
        elif isinstance(step, RangeCurve):
            low, high = max(low, step.ranges[0]), min(high, step.ranges[-1])
    return low, high


def has_response(chain: Chain) -> bool:
    """Whether the chain begins at a reflectance, and not at a number of a reference range."""
    return any(isinstance(step, RESPONSES) for step in chain)


def respond(chain: Chain, light: Floats, distance: Floats) -> Floats:
    """Number that the instrument gives for a reflectance, (n,); NaN outside a step's domain.

    Parameters
    ----------
    light : (n,) array
        Apparent reflectance.
    distance : (n,) array
        Metres.
    """
    for step in chain:
        light = step.respond(light, distance)
    return light


def invert(chain: Chain, number: Floats, distance: Floats) -> Floats:
    """Reflectance that gives a number at a distance, (n,); NaN outside a step's domain."""
    for step in reversed(chain):
        number = step.invert(number, distance)
    return number


def linearise(chain: Chain, light: Floats, distance: Floats) -> Linearised:
    """Value and derivatives of a chain, by the chain rule."""
    light = np.asarray(light, float)
    slope, range_slope = np.ones(light.shape), np.zeros(light.shape)
    rows: list[Floats] = []
    for step in chain:
        own = step.slope(light, distance)
        rows = [row * own for row in rows] + list(step.gradient(light, distance))
        range_slope = range_slope * own + step.range_slope(light, distance)
        slope = slope * own
        light = step.respond(light, distance)
    gradient = np.stack(rows) if rows else np.empty((0, *light.shape))
    return Linearised(light, slope, gradient, range_slope)
