"""Logarithmic and linear amplifiers from panels at one range, with drift and a saturated panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from app.core.arrays import Bools, Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.budget import error_budget
from app.core.radiometry.calibration import Calibration, Wishes, calibrate, make_channel
from app.core.radiometry.linear_response import LinearResponse
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.profile import Noise
from app.core.radiometry.residuals import recover_reflectance
from app.core.radiometry.step import Step
from app.core.radiometry.unknowns import Unknowns
from app.services.bench.results import ResultTable, Value

PANELS = {"99 %": 0.99, "50 %": 0.50, "25 %": 0.25, "12 %": 0.12}
FIXED = "50 %"
DISTANCE = 4.4
SCANS = 8
DRIFT = 0.05
PANEL_SIGMA = 0.02
"""σ of a panel's reflectance, as a share of it."""
TARGETS = (0.08, 0.15, 0.3, 0.45, 0.6)
SEEDS = 200


@dataclass(frozen=True, slots=True)
class Amplifier:
    """A made-up amplifier in the scale of an instrument of the paper."""

    name: str
    model: str
    step: LogResponse | LinearResponse
    wavelength: float
    saturated: float
    mean_noise: float
    point_noise: float


AMPLIFIERS = (
    Amplifier(
        name="FARO X330, logarithmic",
        model="junttila-log",
        step=LogResponse(1200.0, 2100.0),
        wavelength=1550.0,
        saturated=2033.0,
        mean_noise=1.5,
        point_noise=12.0,
    ),
    Amplifier(
        name="HDS6100, linear",
        model="junttila-linear",
        step=LinearResponse(2.6e-4, 0.35),
        wavelength=690.0,
        saturated=2048.0,
        mean_noise=3.0,
        point_noise=25.0,
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One seed.

    Attributes
    ----------
    covered : (p,) array of bool
        Whether the 95 % intervals hold the two numbers of the response and the powers.
    names : tuple of str
    left_out : int
        Saturated rows.
    square, variance : float
        Of the reflectance of independent targets: mean squared error, and the budget's.
    """

    covered: Bools
    names: tuple[str, ...]
    left_out: int
    square: float
    variance: float


def make_panels(amplifier: Amplifier, random: np.random.Generator) -> tuple[PanelTable, Floats]:
    """Means of panels whose reflectance is known to 2 %, in scans that drift; and the powers."""
    powers = 1.0 + DRIFT * random.uniform(-1.0, 1.0, SCANS)
    powers[0] = 1.0
    told = np.array(list(PANELS.values()))
    true = told * (1.0 + PANEL_SIGMA * random.standard_normal(len(told)))
    rho, light = np.tile(told, SCANS), np.tile(true, SCANS) * np.repeat(powers, len(told))
    distance = np.full(len(rho), DISTANCE)
    dn = amplifier.step.respond(light, distance)
    dn = np.minimum(
        dn + amplifier.mean_noise * random.standard_normal(len(dn)), amplifier.saturated
    )
    table = make_table(
        distance,
        np.minimum(dn, amplifier.saturated),
        rho,
        amplifier.wavelength,
        scan=[f"scan {k}" for k in range(1, SCANS + 1) for _ in PANELS],
        panel=[*PANELS] * SCANS,
        reflectance_sigma=PANEL_SIGMA * rho,
    )
    return table, powers


def fit_panels(amplifier: Amplifier, table: PanelTable) -> Calibration:
    """The response and the power of each scan, with the 50 % panel as reference of the drift."""
    wishes = Wishes(saturated=amplifier.saturated, fixed_panels=(FIXED,))
    return calibrate(table, choose_model(amplifier.model), wishes)


def run_trial(amplifier: Amplifier, seed: int) -> Trial:
    """Calibrate on one seed, and measure single returns of other targets in the first scan."""
    random = np.random.default_rng([seed, int(amplifier.wavelength)])
    table, powers = make_panels(amplifier, random)
    found = fit_panels(amplifier, table)
    steps: tuple[Step, ...] = (amplifier.step,)
    truth = np.concatenate([chains.values(steps), powers[1:]])
    error, sigma = _measure_targets(amplifier, found, random)
    return Trial(
        (found.fit.low <= truth) & (truth <= found.fit.high),
        found.fit.found.names,
        found.saturated,
        float(np.mean(error**2)),
        float(np.mean(sigma**2)),
    )


def tabulate(trials: dict[str, list[Trial]]) -> ResultTable:
    """Coverage of the response and the drift, and the error of reflectance beside the budget."""
    rows: list[dict[str, Value]] = []
    for name, found in trials.items():
        covered = np.mean([trial.covered for trial in found], axis=0)
        observed = float(np.sqrt(np.mean([trial.square for trial in found])))
        predicted = float(np.sqrt(np.mean([trial.variance for trial in found])))
        rows.append(
            {
                "instrument": name,
                "seeds": len(found),
                "saturated_rows_left_out": float(np.mean([trial.left_out for trial in found])),
                "first_parameter": found[0].names[0],
                "first_coverage": float(covered[0]),
                "second_parameter": found[0].names[1],
                "second_coverage": float(covered[1]),
                "power_coverage": float(covered[2:].mean()),
                "rmse_percent": 100 * observed,
                "budget_percent": 100 * predicted,
                "ratio": observed / predicted,
            }
        )
    return ResultTable(
        "junttila",
        "Amplifiers from panels of 50, 25 and 12 %; the saturated 99 % panel is left out",
        rows,
        f"Panels known to {PANEL_SIGMA:.0%} (σ, the same error in all scans), {SCANS} scans whose"
        f" power drifts by up to {DRIFT:.0%}. Made-up amplifiers: the paper does not print its"
        " numbers.",
    )


def run_trials(seeds: int, progress: Progress = QUIET) -> dict[str, list[Trial]]:
    """Trials by instrument."""
    found: dict[str, list[Trial]] = {}
    for place, amplifier in enumerate(AMPLIFIERS):
        found[amplifier.name] = []
        for seed in range(seeds):
            progress.report((place + seed / seeds) / len(AMPLIFIERS), "Calibrating amplifiers")
            found[amplifier.name].append(run_trial(amplifier, seed))
    return found


def _measure_targets(
    amplifier: Amplifier, found: Calibration, random: np.random.Generator
) -> tuple[Floats, Floats]:
    """Error of single returns of other targets and its σ by the budget, (n,)."""
    rho, distance = np.array(TARGETS), np.full(len(TARGETS), DISTANCE)
    dn = amplifier.step.respond(rho, distance)
    dn = dn + amplifier.point_noise * random.standard_normal(len(dn))
    # The noise of a single return is larger than that of the panels' means, and known.
    channel = replace(make_channel(found), noise=Noise(amplifier.point_noise))
    steps = Unknowns(found.fit.found.steps, ("1",), np.ones(1), np.zeros(1, bool))
    reflectance = recover_reflectance(steps, make_table(distance, dn, rho, amplifier.wavelength))
    return reflectance - rho, error_budget(channel, reflectance, dn, distance).sigma
