"""A joint fit of SALCA against the staged one, and against a fitting routine left to itself."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import PanelTable, find_fixed_panels
from app.core.radiometry.range_effect import AnalyticRange
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.staged import fit_stages
from app.core.radiometry.start import Ranging
from app.core.radiometry.step import Step
from app.services.bench.radiometry.hancock import (
    FIXED_RANGE,
    NOISES,
    REFERENCE_SCAN,
    TABLE_III,
    TARGET_RANGES,
    TARGETS,
    fit_panels,
    make_panels,
    name_noise,
    true_steps,
)
from app.services.bench.results import ResultTable, Value

NAME = "radiometry_fits"
SEEDS, QUICK_SEEDS = 10, 1
HOPELESS = 0.2
"""Relative error of reflectance above which a fit has failed."""
GUESS = (50.0, 400.0, 10.0, 2.0, 0.3, 0.7)
"""m, c, k, a, k2, k3 as somebody who has read the paper would start."""
NOTE = (
    "Panels of Table III: 30 sets of six, 15 powers. Reflectance of independent targets whose "
    "numbers have no noise and whose power is 1, so that the error is that of the calibration "
    f"alone; failed: no fit, no reflectance for a target, or more than {HOPELESS:.0%} off. "
    "curve_fit: scipy's, not weighted, derivatives by differences, all parameters from 1, or from "
    "values that are about right."
)

Fit = Callable[[PanelTable], tuple[Step, ...]]


@dataclass(frozen=True, slots=True)
class Attempt:
    """One fit: seconds, and the relative RMSE of reflectance, infinite where it failed."""

    seconds: float
    error: float


def compare_fits(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All ways, both channels, both noises.

    Raises
    ------
    Cancelled
    """
    seeds = QUICK_SEEDS if quick else SEEDS
    rows: list[dict[str, Value]] = []
    todo = [(nm, noise) for noise in NOISES for nm in TABLE_III]
    for place, (nm, noise) in enumerate(todo):
        attempts: dict[str, list[Attempt]] = {name: [] for name in WAYS}
        for seed in range(seeds):
            progress.report((place + seed / seeds) / len(todo), "Comparing fits")
            table = make_panels(nm, noise, np.random.default_rng([seed, nm]))
            for name, fit in WAYS.items():
                attempts[name].append(attempt(fit, table, nm))
        rows += [
            {"wavelength_nm": nm, "noise": name_noise(noise), **_tell(name, tried)}
            for name, tried in attempts.items()
        ]
    return ResultTable(NAME, "Fitting SALCA's twelve numbers and fourteen powers", rows, NOTE)


def _tell(name: str, tried: list[Attempt]) -> dict[str, Value]:
    good = [each.error for each in tried if each.error <= HOPELESS]
    return {
        "fit": name,
        "seconds": float(f"{np.median([each.seconds for each in tried]):.3g}"),
        "rmse_percent": float(f"{100 * np.median(good):.3g}") if good else float("nan"),
        "failed": len(tried) - len(good),
        "of": len(tried),
    }


def attempt(fit: Fit, table: PanelTable, wavelength: int) -> Attempt:
    """Fit, and measure targets that have no noise."""
    rho, away = (a.ravel() for a in np.meshgrid(TARGETS, TARGET_RANGES))
    dn = chains.respond(true_steps(wavelength), rho, away)
    start = time.perf_counter()
    try:
        steps = fit(table)
    except (BadInput, RuntimeError):  # scipy says so when it gives up
        return Attempt(time.perf_counter() - start, np.inf)
    seconds = time.perf_counter() - start
    error = float(np.sqrt(np.mean((chains.invert(steps, dn, away) / rho - 1.0) ** 2)))
    return Attempt(seconds, np.inf if np.isnan(error) else error)


def fit_jointly(table: PanelTable) -> tuple[Step, ...]:
    """Ours: the stages, then everything together."""
    return fit_panels(table).fit.found.steps


def fit_in_stages(table: PanelTable) -> tuple[Step, ...]:
    """The paper's three stages alone."""
    fixed = find_fixed_panels(table)
    ranging = Ranging(FIXED_RANGE)
    return fit_stages(table, choose_model("hancock"), ranging, fixed, REFERENCE_SCAN).steps


def fit_from_ones(table: PanelTable) -> tuple[Step, ...]:
    """Scipy's curve_fit, everything from 1."""
    return _fit_curve(table, (1.0,) * 6)


def fit_from_guess(table: PanelTable) -> tuple[Step, ...]:
    """Scipy's curve_fit from values that are about right, powers from 1."""
    return _fit_curve(table, GUESS)


WAYS: dict[str, Fit] = {
    "joint": fit_jointly,
    "staged": fit_in_stages,
    "curve_fit from 1": fit_from_ones,
    "curve_fit from a guess": fit_from_guess,
}


@np.errstate(all="ignore")
def _fit_curve(table: PanelTable, start: tuple[float, ...]) -> tuple[Step, ...]:
    import warnings

    from scipy.optimize import OptimizeWarning, curve_fit

    scan = table.index_scans()
    others = len(table.scans) - 1
    known = table.scans.index(REFERENCE_SCAN)

    def predict(_: Floats, *values: float) -> Floats:
        m, c, k, a, k2, k3 = values[:6]
        power = np.insert(np.array(values[6:]), known, 1.0)[scan]
        x = table.reflectance * power * _strength(table.distance, a, k2, k3)
        return np.asarray((m * x + c) * (1.0 - np.exp(-k * x)))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)
        found = curve_fit(predict, table.distance, table.dn, (*start, *[1.0] * others))[0]
    m, c, k, a, k2, k3 = map(float, found[:6])
    return AnalyticRange(a, k2, k3), SalcaResponse(m, c, k)


def _strength(away: Floats, a: float, k2: float, k3: float) -> Floats:
    def level(r: Floats) -> Floats:
        return np.asarray(r**-a * (1.0 - np.exp(-k2 * r)) ** k3)

    return np.asarray(level(away) / level(np.array(FIXED_RANGE)))
