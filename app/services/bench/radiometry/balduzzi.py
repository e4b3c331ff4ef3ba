"""A log instrument's range effect by equations 6 and 7, with the scatter of Balduzzi's Table 2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.calibration import Calibration, Wishes, calibrate
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.models import choose_model
from app.core.radiometry.panels import PanelTable, make_table
from app.core.radiometry.range_curve import PolynomialCurve
from app.core.radiometry.range_shift import scale_to_reference, shift_to_reference
from app.core.radiometry.step import Step
from app.services.bench.results import ResultTable, Value

MATERIALS = {
    "83 % paper": (0.83, 2.98),
    "80 % paper": (0.80, 2.50),
    "68 % paper": (0.68, 1.60),
    "48 % paper": (0.48, 3.66),
    "22 % grey card": (0.22, 11.49),
    "3 % paper": (0.03, 21.52),
    "3 % paint": (0.03, 11.49),
}
"""Reflectance, and the RMSE of the corrected DN of Table 2."""
PANEL, PANEL_SCATTER = 0.99, 2.5
"""The white panel; its scatter is not published, that of bright paper is taken."""
DECADE = 600.0
"""DN per decade of the amplifier."""
REFERENCE, REFERENCE_DN = 3.56, 1781.45
RANGES = (0.35, 0.45, 0.6, 0.75, 0.8, 1.15, 1.85, 2.15, 2.6, 3.56, 5.0, 7.5, 10.0)
NEAREST = 1.0
"""Metres beyond which the paper judges the correction."""
NEAR_FIELD = 1.2
"""Metres below which the made-up instrument loses light."""
RETURNS = 100
"""Returns from each target at each range."""
SEEDS = 200


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One seed: RMSE of the corrected DN by material for both equations, and the amplifier.

    `covered` says whether the 95 % interval of the DN per decade holds the truth.
    """

    seventh: Floats
    sixth: Floats
    decade: float
    covered: bool


def true_steps() -> tuple[Step, ...]:
    """Amplifier and range effect that the data are made with."""
    away = np.array(RANGES)
    strength = away**2 / (away**2 + NEAR_FIELD**2) ** 2
    level = DECADE * np.log10(strength)
    level -= level[RANGES.index(REFERENCE)]
    offset = REFERENCE_DN - DECADE * np.log10(PANEL)
    curve = PolynomialCurve("additive", RANGES, tuple(level.tolist()), REFERENCE, 2)
    return LogResponse(DECADE, float(offset)), curve


def expect(reflectance: float, distance: Floats) -> Floats:
    """DN of a target without scatter."""
    return chains.respond(true_steps(), np.full(len(distance), reflectance), distance)


def make_panels(random: np.random.Generator | None) -> PanelTable:
    """Means of the returns of all targets at all ranges; without scatter for no random."""
    targets = {"99 % panel": (PANEL, PANEL_SCATTER), **MATERIALS}
    away = np.tile(RANGES, len(targets))
    rho = np.repeat([value for value, _ in targets.values()], len(RANGES))
    sigma = np.repeat([scatter for _, scatter in targets.values()], len(RANGES))
    sigma = sigma / np.sqrt(RETURNS)
    dn = chains.respond(true_steps(), rho, away)
    if random is not None:
        dn = dn + sigma * random.standard_normal(len(dn))
    names = [f"{name}" for name in targets for _ in RANGES]
    return make_table(away, dn, rho, 785.0, panel=names, dn_sigma=sigma)


def fit_panels(table: PanelTable) -> Calibration:
    """The logarithmic response with a piecewise polynomial over range."""
    return calibrate(table, choose_model("balduzzi"), Wishes(reference_range=REFERENCE))


def correct(
    found: Calibration, dn: Floats, distance: Floats, reflectance: float
) -> tuple[Floats, Floats]:
    """DN at the reference range by equations 7 and 6, with the panel's curve of a calibration."""

    def curve(away: Floats) -> Floats:
        return chains.respond(found.fit.found.steps, np.full(len(away), PANEL), away)

    own = expect(reflectance, np.array([REFERENCE]))[0]
    seventh = shift_to_reference(dn, distance, curve, REFERENCE)
    return seventh, scale_to_reference(dn, distance, curve, REFERENCE, float(own))


def run_trial(seed: int) -> Trial:
    """Calibrate on one seed, then correct single returns of each material."""
    random = np.random.default_rng(seed)
    found = fit_panels(make_panels(random))
    away = np.repeat([distance for distance in RANGES if distance > NEAREST], RETURNS)
    seventh: list[float] = []
    sixth: list[float] = []
    for rho, scatter in MATERIALS.values():
        dn = expect(rho, away) + scatter * random.standard_normal(len(away))
        target = expect(rho, np.array([REFERENCE]))[0]
        for kept, value in zip((seventh, sixth), correct(found, dn, away, rho), strict=True):
            kept.append(float(np.sqrt(np.mean((value - target) ** 2))))
    place = found.fit.found.names.index("a0")
    return Trial(
        np.array(seventh),
        np.array(sixth),
        float(found.fit.found.natural()[place]),
        bool(found.fit.low[place] <= DECADE <= found.fit.high[place]),
    )


def tabulate_scatter(trials: Sequence[Trial]) -> ResultTable:
    """Mean RMSE of the corrected DN beside the column of Table 2."""
    seventh = np.mean([trial.seventh for trial in trials], axis=0)
    sixth = np.mean([trial.sixth for trial in trials], axis=0)
    rows: list[dict[str, Value]] = [
        {
            "material": name,
            "paper_rmse_dn": scatter,
            "equation_7_rmse_dn": float(seventh[k]),
            "equation_7_ratio": float(seventh[k] / scatter),
            "equation_6_rmse_dn": float(sixth[k]),
            "equation_6_ratio": float(sixth[k] / scatter),
            "seeds": len(trials),
        }
        for k, (name, (_, scatter)) in enumerate(MATERIALS.items())
    ]
    return ResultTable(
        "balduzzi_scatter",
        "Corrected DN beyond 1 m: RMSE by material",
        rows,
        "The paper's RMSE is the scatter that the data are made with. Equation 6 stretches it by"
        " I(d_ref) / I(d); it also needs the target's own DN at the reference range.",
    )


def tabulate_amplifier(trials: Sequence[Trial]) -> ResultTable:
    """The DN per decade that the fits found, and equations 6 and 7 without scatter."""
    decades = np.array([trial.decade for trial in trials])
    rows: list[dict[str, Value]] = [
        {
            "truth_dn_per_decade": DECADE,
            "mean": float(decades.mean()),
            "rmse": float(np.sqrt(np.mean((decades - DECADE) ** 2))),
            "coverage": float(np.mean([trial.covered for trial in trials])),
            "seeds": len(trials),
            "equations_differ_dn": compare_equations(),
        }
    ]
    return ResultTable(
        "balduzzi_amplifier",
        "The amplifier from the same panels",
        rows,
        "equations_differ_dn: largest difference of equations 6 and 7 without scatter.",
    )


def compare_equations() -> float:
    """Largest difference of equations 6 and 7 without scatter, DN."""
    found = fit_panels(make_panels(None))
    away = np.array(RANGES)
    worst = 0.0
    for rho, _ in MATERIALS.values():
        seventh, sixth = correct(found, expect(rho, away), away, rho)
        worst = max(worst, float(np.abs(seventh - sixth).max()))
    return worst


def run_trials(seeds: int, progress: Progress = QUIET) -> list[Trial]:
    """A trial for each seed."""
    found = []
    for seed in range(seeds):
        progress.report(seed / seeds, "Correcting range")
        found.append(run_trial(seed))
    return found
