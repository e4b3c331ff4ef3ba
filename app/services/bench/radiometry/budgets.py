"""Is the error budget right? Predicted σ of reflectances against errors in simulated scans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.progress import QUIET, Progress
from app.core.radiometry.budget import PARTS, Budget, error_budget, mean_budget
from app.core.radiometry.marks import reflect
from app.services.bench.radiometry.new_scans import TARGETS, NewScan, scan_targets
from app.services.bench.radiometry.plans import PLANS, Calibrated, Plan, carry_out
from app.services.bench.results import ResultTable, Value

NAME = "radiometry_budget"
SEEDS, QUICK_SEEDS = 120, 1
NOTE = (
    "Each seed: panels with errors of their own scanned at 10 to 15 ranges, a calibration from the "
    "means of their points, a new scan of targets of other reflectances at other ranges, with "
    "another power of the laser where it is measured. rms: of found less true; predicted: root "
    "mean square of the budget's σ; ratio: rms over predicted. Parts in percent of the "
    "reflectance. mean: of about 200 points of a target at one range."
)


@dataclass(frozen=True, slots=True)
class Tally:
    """Mean squares of one target in one seed.

    Attributes
    ----------
    error, bias : float
        Mean squared error, and mean error, of the reflectance.
    parts : tuple of float
        Mean squared σ by cause.
    points : int
    lost : int
        Points without a reflectance.
    """

    error: float
    bias: float
    parts: tuple[float, ...]
    points: int
    lost: int


Key = tuple[Plan, int, float, str]
"""Plan, channel, reflectance, and whether of points or means."""


def prove_budget(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All plans, all seeds.

    Raises
    ------
    Cancelled
    """
    seeds = QUICK_SEEDS if quick else SEEDS
    found: dict[Key, list[Tally]] = {}
    for place, plan in enumerate(PLANS):
        for seed in range(seeds):
            progress.report((place + seed / seeds) / len(PLANS), f"Budget of {plan.instrument}")
            calibrated = carry_out(plan, seed)
            _compare(plan, calibrated, scan_targets(plan, calibrated, seed), found)
    rows = [_tell(key, tallies) for key, tallies in found.items()]
    return ResultTable(NAME, "The error budget against observed errors", rows, NOTE)


def _compare(
    plan: Plan, calibrated: Calibrated, scan: NewScan, found: dict[Key, list[Tally]]
) -> None:
    for k, channel in enumerate(calibrated.channels):
        dn, power, sigma = scan.dn[:, k], float(scan.power[k]), float(scan.power_sigma[k])
        rho, _ = reflect(channel, dn, scan.distance, power)
        error = rho - scan.rho[:, k]
        pull = scan.power_pull[k]
        budget = error_budget(channel, rho, dn, scan.distance, power, sigma, pull)
        for number, target in enumerate(TARGETS):
            mine = scan.target == number
            points = found.setdefault((plan, k, target, "point"), [])
            points.append(_gather(error[mine], _pick(budget, mine)))
            means = found.setdefault((plan, k, target, "mean"), [])
            for place in range(len(plan.targets)):
                here = mine & (scan.place == place)
                whole = mean_budget(
                    channel, rho[here], dn[here], scan.distance[here], power, sigma, pull
                )
                means.append(_gather(np.nanmean(error[here], keepdims=True), whole))


def _pick(budget: Budget, rows: Bools) -> Budget:
    return Budget(*(part[rows] for part in budget))


def _gather(error: Floats, budget: Budget) -> Tally:
    known = np.isfinite(error)
    parts = tuple(float(np.mean(part[known] ** 2)) for part in budget)
    away = error[known]
    lost = int((~known).sum())
    return Tally(float(np.mean(away**2)), float(away.mean()), parts, len(error), lost)


def _tell(key: Key, tallies: Sequence[Tally]) -> dict[str, Value]:
    plan, channel, target, of = key
    parts = np.sqrt(np.mean([tally.parts for tally in tallies], axis=0))
    observed = float(np.sqrt(np.mean([tally.error for tally in tallies])))
    predicted = float(np.sqrt(np.sum(parts**2)))
    percent = 100.0 / target
    return {
        "instrument": _name(plan, channel),
        "power_from": plan.drift,
        "reflectance": target,
        "of": of,
        "count": sum(tally.points for tally in tallies),
        "lost": sum(tally.lost for tally in tallies),
        "rms_percent": _round(percent * observed),
        "predicted_percent": _round(percent * predicted),
        "ratio": _round(observed / predicted),
        "bias_percent": _round(percent * float(np.mean([tally.bias for tally in tallies]))),
        **{
            f"{name}_percent": _round(percent * float(part))
            for name, part in zip(PARTS, parts, strict=True)
        },
        "largest": PARTS[int(np.argmax(parts))],
    }


def _name(plan: Plan, channel: int) -> str:
    return (
        f"{plan.instrument} {(1063, 1545)[channel]} nm"
        if plan.instrument == "salca"
        else plan.instrument
    )


def _round(value: float) -> float:
    return float(f"{value:.3g}")
