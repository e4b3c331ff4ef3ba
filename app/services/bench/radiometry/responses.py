"""Every inverse of the chain: how fast on one core, how exact, and against what is simpler."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry.linear_response import LinearResponse, Proportional
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.range_curve import PolynomialCurve, SplineCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import BRIGHTEST, SalcaResponse
from app.core.radiometry.step import Step
from app.services.bench.results import ResultTable, Value
from app.services.bench.timing import time_in_turns, use_threads

NAME = "radiometry_inverses"
POINTS, QUICK_POINTS = 1_000_000, 50_000
SOLVED, QUICK_SOLVED = 2000, 100
"""Points for a root finder that is called for each."""
TURNS, QUICK_TURNS = 7, 3
KNOTS = 1000
DEGREE = 4
RANGES = (0.35, 0.45, 0.6, 0.75, 0.8, 1.15, 1.85, 2.15, 2.6, 3.56, 5.0, 7.5, 10.0)
"""Metres: those of Balduzzi's panel."""
REFERENCE, NEAR = 3.56, 3.0
OURS = "ours"
NOTE = (
    "invert(respond(x)) of values drawn on a logarithmic scale over the domain, on one core, "
    "medians of turns that the ways take; time: of a point, over ours. Error: the largest of x, "
    f"relative. A table has {KNOTS} knots; a polynomial of degree {DEGREE} goes through the same "
    "ranges as the curve. brentq is called for each of fewer points."
)

Invert = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True, slots=True)
class Inverse:
    """A step, and where it is asked.

    Attributes
    ----------
    name : str
    step : Step
    domain : (low, high)
        Of x.
    ranges : (low, high)
        Metres.
    goal : float
        Million points per second.
    """

    name: str
    step: Step
    domain: tuple[float, float]
    ranges: tuple[float, float]
    goal: float = 20.0


def list_inverses() -> list[Inverse]:
    """All steps that have numbers, with those of the papers where they are printed."""
    rho, near, far = (1e-4, 1.5), (2.0, 60.0), (RANGES[0], RANGES[-1])
    levels = curve_levels()
    shifts = tuple(float(level) for level in 600.0 * np.log10(levels))
    salca = {1545: (137.21, 407.04, 16.83), 1063: (35.19, 342.45, 7.33)}
    light = (1e-6, BRIGHTEST)
    return [
        Inverse("logarithmic", LogResponse(600.0, 1784.07), rho, near),
        Inverse("linear", LinearResponse(2.99e-4, 0.367), rho, near),
        Inverse("proportional", Proportional(1e4), rho, near),
        Inverse("decibel", Decibel(), rho, near),
        *(
            Inverse(f"SALCA {nm} nm", SalcaResponse(*v), light, near, 2.0)
            for nm, v in salca.items()
        ),
        Inverse("inverse square", InverseSquare(8.0), rho, near),
        Inverse("analytic range, outer", AnalyticRange(1.5, 0.18, 0.84), rho, near),
        Inverse("analytic range, inner", AnalyticRange(1.5, 0.18, 0.84, "inner"), rho, near),
        *(
            Inverse(
                f"polynomial of order {order}",
                PolynomialCurve("multiplicative", RANGES, levels, REFERENCE, order),
                rho,
                far,
            )
            for order in (1, 2)
        ),
        Inverse(
            "polynomial, additive",
            PolynomialCurve("additive", RANGES, shifts, REFERENCE, 2),
            (1.0, 2047.0),
            far,
        ),
        Inverse("spline", SplineCurve("multiplicative", RANGES, levels, REFERENCE), rho, far),
    ]


def curve_levels() -> tuple[float, ...]:
    """An inverse square that levels off near by, at `RANGES`, over that at the reference."""
    away = np.array(RANGES)
    level = (REFERENCE**2 + NEAR**2) / (away**2 + NEAR**2)
    return tuple(map(float, level))


def measure_inverses(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """Time and error of each inverse and its simple alternatives.

    Raises
    ------
    Cancelled
    """
    inverses = list_inverses()
    rows: list[dict[str, Value]] = []
    for place, inverse in enumerate(inverses):
        part = progress.part(place / len(inverses), (place + 1) / len(inverses))
        rows += _measure(inverse, quick, part)
    return ResultTable(NAME, "Inverses, on one core", rows, NOTE)


def _measure(inverse: Inverse, quick: bool, progress: Progress) -> list[dict[str, Value]]:
    count = QUICK_POINTS if quick else POINTS
    random = np.random.default_rng(7)
    low, high = inverse.domain
    x = np.exp(random.uniform(np.log(low), np.log(high), count))
    away = random.uniform(*inverse.ranges, count)
    y = inverse.step.respond(x, away)
    solved = QUICK_SOLVED if quick else SOLVED
    ways = list_ways(inverse)
    counts = {name: solved if name == "brentq" else count for name in ways}
    runs = {name: _bind(way, y[: counts[name]], away[: counts[name]]) for name, way in ways.items()}
    errors = {name: _find_error(run(), x[: counts[name]]) for name, run in runs.items()}
    with use_threads(1):
        timings = time_in_turns(runs, QUICK_TURNS if quick else TURNS, progress)
    each = {name: timings[name].median / counts[name] for name in ways}
    return [
        {
            "inverse": inverse.name,
            "way": name,
            "points": counts[name],
            "million_per_s": float(f"{1e-6 / each[name]:.4g}"),
            "time": float(f"{each[name] / each[OURS]:.3g}"),
            "largest_error": float(f"{errors[name]:.3g}"),
            "goal_million_per_s": inverse.goal if name == OURS else float("nan"),
        }
        for name in ways
    ]


def _bind(way: Invert, y: Floats, away: Floats) -> Callable[[], Floats]:
    return lambda: way(y, away)


def _find_error(found: Floats, x: Floats) -> float:
    """Largest relative error; infinite where a value is missing."""
    away = np.abs(found / x - 1.0)
    return float(np.where(np.isnan(away), np.inf, away).max())


def list_ways(inverse: Inverse) -> Mapping[str, Invert]:
    """Ours, and what is simpler."""
    step = inverse.step
    ways: dict[str, Invert] = {OURS: step.invert}
    if isinstance(step, (SalcaResponse, LogResponse)):
        ways["table"] = _tabulate_response(step, inverse.domain)
    if isinstance(step, SalcaResponse):
        ways["brentq"] = _solve_each(step)
    if isinstance(step, AnalyticRange):
        ways["table"] = _tabulate_range(step, inverse.ranges)
    if isinstance(step, (PolynomialCurve, SplineCurve)) and step.scale == "multiplicative":
        ranges, levels = np.array(step.ranges), np.array(step.levels)
        ways["straight lines"] = lambda y, away: y / np.interp(away, ranges, levels)
        whole = np.polyfit(ranges, levels, DEGREE)
        ways["one polynomial"] = lambda y, away: np.asarray(y / np.polyval(whole, away))
    return ways


def _tabulate_response(step: Step, domain: tuple[float, float]) -> Invert:
    x = np.geomspace(*domain, KNOTS)
    y = step.respond(x, np.ones(KNOTS))
    return lambda seen, _: np.interp(seen, y, x)


def _tabulate_range(step: Step, ranges: tuple[float, float]) -> Invert:
    away = np.linspace(*ranges, KNOTS)
    strength = step.respond(np.ones(KNOTS), away)
    return lambda y, distance: np.asarray(y / np.interp(distance, away, strength))


def _solve_each(step: SalcaResponse) -> Invert:
    from scipy.optimize import brentq

    def miss(x: float, y: float) -> float:
        return float(-(step.m * x + step.c) * np.expm1(-step.k * x)) - y

    def solve(y: Floats, _: Floats) -> Floats:
        return np.array([brentq(miss, 0.0, BRIGHTEST, (value,), xtol=1e-15) for value in y])

    return solve
