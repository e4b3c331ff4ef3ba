"""SALCA calibrated again and again on data made with the paper's own parameters (Table III)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.budget import error_budget
from app.core.radiometry.calibration import (
    Calibration,
    Wishes,
    calibrate,
    fit_other_form,
    make_channel,
)
from app.core.radiometry.joint import find_singular, predict
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.power import PowerFound, measure_power
from app.core.radiometry.profile import Noise
from app.core.radiometry.range_effect import AnalyticRange
from app.core.radiometry.residuals import recover_reflectance
from app.core.radiometry.salca import SalcaResponse
from app.core.radiometry.step import Step
from app.services.bench.results import ResultTable, Value

TABLE_III = {
    1545: {"m": 137.21, "c": 407.04, "k": 16.83, "a": 1.50, "k2": 0.18, "k3": 0.84},
    1063: {"m": 35.19, "c": 342.45, "k": 7.33, "a": 1.98, "k2": 0.54, "k3": 0.64},
}
PAPER_RMSE = {1545: 5.6, 1063: 1.9}
"""Percent of reflectance, on independent targets."""
NOISES = (Noise(0.2, 0.002), Noise(1.0, 0.01))
FIXED_RANGE = 8.0
REFLECTANCES = (0.05, 0.1, 0.2, 0.4, 0.65, 0.9)
RANGES = (2.0, 2.7, 3.5, 4.5, 6.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0, 60.0)
LEAST_POWER = 0.5
TARGETS = (0.08, 0.15, 0.3, 0.5, 0.75)
TARGET_RANGES = (2.3, 3.0, 5.0, 7.0, 9.0, 14.0, 18.0, 28.0, 37.0, 55.0)
REFERENCE_SCAN = "scan 6"
"""The movable panel at 8 m; its power is 1."""
SEEDS = 200


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One seed of one channel and noise.

    Attributes
    ----------
    joint, staged : (6,) arrays of bool
        Whether the 95 % interval holds the truth, in the order of `TABLE_III`.
    error : (6,) array
        Found over true, less 1.
    square, variance, bias : float
        Of the reflectance of independent targets: mean squared error, the budget's, mean error.
    """

    joint: Bools
    staged: Bools
    error: Floats
    square: float
    variance: float
    bias: float


def true_steps(wavelength: int) -> tuple[Step, ...]:
    """Range effect and response of Table III."""
    truth = TABLE_III[wavelength]
    effect = AnalyticRange(truth["a"], truth["k2"], truth["k3"])
    return effect, SalcaResponse(truth["m"], truth["c"], truth["k"])


def make_panels(wavelength: int, noise: Noise, random: np.random.Generator) -> PanelTable:
    """A movable set of panels at each range, a fixed one beside it, one power per scan."""
    powers = random.uniform(LEAST_POWER, 1.0, len(RANGES))
    powers[RANGES.index(FIXED_RANGE)] = 1.0
    rows = [
        (rho, distance, f"scan {number}", f"{kind} {rho:g}", power)
        for number, (away, power) in enumerate(zip(RANGES, powers, strict=True), start=1)
        for kind, distance in (("fixed", FIXED_RANGE), ("movable", away))
        for rho in REFLECTANCES
    ]
    rho, distance, scan, panel, power = (np.array(column) for column in zip(*rows, strict=True))
    dn = measure(wavelength, rho * power, distance, noise, random)
    return make_table(distance, dn, rho, wavelength, scan=scan, panel=panel)


def measure(
    wavelength: int, light: Floats, distance: Floats, noise: Noise, random: np.random.Generator
) -> Floats:
    """What SALCA gives for light at distances, DN."""
    dn = chains.respond(true_steps(wavelength), light, distance)
    return dn + noise.sigma(dn) * random.standard_normal(len(dn))


def fit_panels(table: PanelTable, model: str = "hancock") -> Calibration:
    """The staged start and the joint fit, with the power of one scan fixed to 1."""
    return calibrate(table, choose_model(model), Wishes(reference_scan=REFERENCE_SCAN))


def run_trial(wavelength: int, noise: Noise, seed: int) -> Trial:
    """Calibrate on one seed, and measure independent targets with it."""
    random = np.random.default_rng([seed, wavelength])
    found = fit_panels(make_panels(wavelength, noise, random))
    truth = np.array(list(TABLE_III[wavelength].values()))
    places = [found.fit.found.names.index(name) for name in TABLE_III[wavelength]]
    low, high = found.fit.low[places], found.fit.high[places]
    staged = found.staged.intervals if found.staged else {}
    narrow = np.array([staged[name] for name in TABLE_III[wavelength]]).T
    error, sigma = _measure_targets(found, wavelength, noise, random)
    return Trial(
        (low <= truth) & (truth <= high),
        (narrow[0] <= truth) & (truth <= narrow[1]),
        found.fit.found.natural()[places] / truth - 1,
        float(np.mean(error**2)),
        float(np.mean(sigma**2)),
        float(error.mean()),
    )


def tabulate_coverage(trials: dict[tuple[int, Noise], list[Trial]]) -> ResultTable:
    """How often the 95 % intervals hold the truth, joint and staged."""
    rows: list[dict[str, Value]] = []
    for (wavelength, noise), found in trials.items():
        joint = np.mean([trial.joint for trial in found], axis=0)
        staged = np.mean([trial.staged for trial in found], axis=0)
        error = np.sqrt(np.mean([trial.error**2 for trial in found], axis=0))
        for k, (name, value) in enumerate(TABLE_III[wavelength].items()):
            rows.append(
                {
                    "noise": name_noise(noise),
                    "wavelength_nm": wavelength,
                    "parameter": name,
                    "truth": value,
                    "seeds": len(found),
                    "relative_rmse": float(error[k]),
                    "joint_coverage": float(joint[k]),
                    "staged_coverage": float(staged[k]),
                }
            )
    for noise in dict.fromkeys(noise for _, noise in trials):
        rows.append(
            _pool(noise, [t for (_, n), found in trials.items() if n == noise for t in found])
        )
    return ResultTable(
        "hancock_coverage",
        "SALCA from Table III: how often 95 % intervals hold the truth",
        rows,
        "Staged: the paper's three stages, each as if the earlier ones were exact. Noise of the"
        " panels is not told to the fit.",
    )


def tabulate_reflectance(trials: dict[tuple[int, Noise], list[Trial]]) -> ResultTable:
    """Reflectance of independent targets: observed error, the budget's, and the paper's."""
    rows: list[dict[str, Value]] = []
    for (wavelength, noise), found in trials.items():
        observed = float(np.sqrt(np.mean([trial.square for trial in found])))
        predicted = float(np.sqrt(np.mean([trial.variance for trial in found])))
        rows.append(
            {
                "noise": name_noise(noise),
                "wavelength_nm": wavelength,
                "seeds": len(found),
                "rmse_percent": 100 * observed,
                "budget_percent": 100 * predicted,
                "ratio": observed / predicted,
                "bias_percent": 100 * float(np.mean([trial.bias for trial in found])),
                "paper_rmse_percent": PAPER_RMSE[wavelength],
            }
        )
    return ResultTable(
        "hancock_reflectance",
        "SALCA on targets that the fit did not see",
        rows,
        "Targets of other reflectances at other ranges, each range a scan with a power of its own,"
        " found from the fixed panels. The paper's own targets and noise are not those here.",
    )


def tabulate_singular(seed: int = 0) -> ResultTable:
    """Singular values of the scaled Jacobian with the power of one scan fixed, and with none."""
    rows: list[dict[str, Value]] = []
    for wavelength in TABLE_III:
        found = fit_panels(make_panels(wavelength, NOISES[0], np.random.default_rng(seed)))
        free = replace(found.fit.found, sought=np.ones(len(found.fit.found.scans), bool))
        for name, unknowns in (("one fixed", found.fit.found), ("none fixed", free)):
            jacobian = predict(unknowns, found.table)[1] / found.fit.sigma[:, None]
            singular = find_singular(jacobian)[0]
            rows.append(
                {
                    "wavelength_nm": wavelength,
                    "powers": name,
                    "parameters": len(singular),
                    "largest": float(singular[0]),
                    "second_smallest": float(singular[-2]),
                    "smallest": float(singular[-1]),
                }
            )
    return ResultTable(
        "hancock_singular",
        "The coupling that the paper met: m, k and all powers can change together",
        rows,
        "Jacobian with columns of length 1. A smallest value of rounding's size: no unique answer.",
    )


def tabulate_forms(seed: int = 0) -> ResultTable:
    """Fit statistics of both readings of equation A5 on data of the first."""
    rows: list[dict[str, Value]] = []
    for wavelength in TABLE_III:
        for noise in NOISES:
            found = fit_panels(make_panels(wavelength, noise, np.random.default_rng(seed)))
            other = fit_other_form(found)
            fits = [("outer", found.fit), *([("inner", other[1])] if other else [])]
            for form, fit in fits:
                rows.append(
                    {
                        "noise": name_noise(noise),
                        "wavelength_nm": wavelength,
                        "form": form,
                        "chi_square": float(np.sum((fit.residual / found.fit.sigma) ** 2)),
                        "freedom": fit.freedom,
                        "rmse_dn": float(np.sqrt(np.mean(fit.residual**2))),
                    }
                )
    return ResultTable(
        "hancock_forms",
        "Both readings of equation A5, fitted to data made with the outer one",
        rows,
        "χ² with the noise of the outer fit.",
    )


def run_trials(
    seeds: int, progress: Progress = QUIET, noises: Sequence[Noise] = NOISES
) -> dict[tuple[int, Noise], list[Trial]]:
    """Trials by channel and noise."""
    trials: dict[tuple[int, Noise], list[Trial]] = {}
    todo = [(wavelength, noise) for noise in noises for wavelength in TABLE_III]
    for place, key in enumerate(todo):
        trials[key] = []
        for seed in range(seeds):
            progress.report((place + seed / seeds) / len(todo), "Calibrating SALCA")
            trials[key].append(run_trial(*key, seed))
    return trials


def name_noise(noise: Noise) -> str:
    """As in ``0.2 % + 0.2 DN``."""
    return f"{100 * noise.share:g} % + {noise.constant:g} DN"


def _pool(noise: Noise, found: list[Trial]) -> dict[str, Value]:
    error = np.concatenate([trial.error for trial in found])
    return {
        "noise": name_noise(noise),
        "wavelength_nm": "both",
        "parameter": "all",
        "truth": float("nan"),
        "seeds": len(found) // len(TABLE_III),
        "relative_rmse": float(np.sqrt(np.mean(error**2))),
        "joint_coverage": float(np.mean([trial.joint for trial in found])),
        "staged_coverage": float(np.mean([trial.staged for trial in found])),
    }


def _measure_targets(
    found: Calibration, wavelength: int, noise: Noise, random: np.random.Generator
) -> tuple[Floats, Floats]:
    """Error of the reflectance of independent targets and its σ by the budget, (n,)."""
    channel = make_channel(found)
    errors, sigmas = [], []
    for away in TARGET_RANGES:
        true_power = random.uniform(LEAST_POWER, 1.0)
        power, sigma, pull = _find_power(found, wavelength, true_power, noise, random)
        rho, distance = np.array(TARGETS), np.full(len(TARGETS), away)
        dn = measure(wavelength, rho * true_power, distance, noise, random)
        seen = make_table(distance, dn, rho, wavelength, scan=["new"] * len(rho))
        unknowns = replace(found.fit.found, scans=("new",), powers=np.array([power]))
        reflectance = recover_reflectance(unknowns, seen)
        budget = error_budget(channel, reflectance, dn, distance, power, sigma, pull)
        known = np.isfinite(reflectance)
        errors.append((reflectance - rho)[known])
        sigmas.append(budget.sigma[known])
    return np.concatenate(errors), np.concatenate(sigmas)


def _find_power(
    found: Calibration,
    wavelength: int,
    true_power: float,
    noise: Noise,
    random: np.random.Generator,
) -> PowerFound:
    """Power of a new scan from its fixed panels."""
    rho, distance = np.array(REFLECTANCES), np.full(len(REFLECTANCES), FIXED_RANGE)
    dn = measure(wavelength, rho * true_power, distance, noise, random)
    return measure_power(make_channel(found), dn, distance, rho)
