"""Data at the edge of what there is: the fit must be right, or refuse in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.fitting import FitResult, fit
from app.core.fitting.bins import average_bins
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.services.bench.fit.curves import BECKMANN, STEPS, draw_curve
from app.services.bench.results import ResultTable, Value

F, K_D, M = 1.0, 0.5, 0.3
EXACT = 1e-6
NOTE = "Lambert–Beckmann; exact curves unless told otherwise. error: the largest of f, k_d and m."
Check = Callable[[FitResult], float]


@dataclass(frozen=True, slots=True)
class Case:
    """Pairs, and how wrong a fit of them is; None where it must be refused."""

    name: str
    angle: Floats
    value: Floats
    error: Check | None


def check_stability(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """A row for each case; ``right`` and ``refused`` are what may be."""
    cases = list(list_cases(quick))
    rows: list[dict[str, Value]] = []
    for place, case in enumerate(cases):
        progress.report(place / len(cases), case.name)
        rows.append(try_case(case))
    return ResultTable("fit_stability", "Data at the edge", rows, NOTE)


def try_case(case: Case) -> dict[str, Value]:
    """Fit a case and judge what comes."""
    error, words = np.nan, ""
    try:
        result = fit(BECKMANN, case.angle, case.value)
    except BadInput as refusal:
        verdict, words = "refused" if case.error is None else "WRONG", str(refusal)
    else:
        error = np.inf if case.error is None else case.error(result)
        verdict = "right" if error <= EXACT else "WRONG"
        words = " ".join(result.warnings)
    return {
        "case": case.name, "points": len(case.value), "error": float(f"{error:.3g}"),
        "verdict": verdict, "words": words,
    }  # fmt: skip


def list_cases(quick: bool) -> Iterator[Case]:
    """Sizes, counts, angles, shapes, and data that must be refused."""
    yield from _list_sizes(quick)
    yield from _list_angles()
    yield from _list_shapes()
    yield from _list_refusals()


def _list_sizes(quick: bool) -> Iterator[Case]:
    curve, near = draw_curve(STEPS, F, K_D, M), _near(F, K_D, M)
    for power in (-12, -6, 6, 12):
        yield Case(
            f"intensity of 1e{power}", STEPS, 10.0**power * curve, _near(10.0**power, K_D, M)
        )
    rng = np.random.default_rng(6)
    for count in (4, 5, 100, 10_000) if quick else (4, 5, 100, 10_000, 1_000_000):
        angle = np.linspace(0.0, 1.0, count) if count < 10 else rng.uniform(0.0, 1.4, count)
        yield Case(f"{count} points", angle, draw_curve(angle, F, K_D, M), near)
    drawn = rng.standard_normal(len(STEPS))
    noisy = curve + 0.05 * drawn - 0.06
    noisy[-1] = -abs(noisy[-1])
    yield Case("negative values", STEPS, noisy, _is_finite)
    holes = np.where(np.arange(len(STEPS)) % 4 == 1, np.nan, curve)
    yield Case("a quarter NaN", STEPS, holes, near)


def _list_angles() -> Iterator[Case]:
    def draw(name: str, degrees: Floats, check: Check) -> Case:
        angle = np.asarray(to_radians(degrees))
        return Case(name, angle, draw_curve(angle, F, K_D, M), check)

    near = _near(F, K_D, M)
    yield draw("4 angles, 50 times each", np.tile([0.0, 20.0, 40.0, 60.0], 50), near)
    yield draw("angles to 89.99°", np.append(np.arange(0.0, 90.0, 3.0), [89.9, 89.99]), near)
    yield draw("90° is left out", np.append(np.arange(0.0, 81.0, 5.0), 90.0), near)
    yield draw("angles to 0.06°", np.linspace(0.0, 0.06, 40), _is_finite)


def _list_shapes() -> Iterator[Case]:
    fine = np.geomspace(1e-4, 1.4, 200)
    yield Case("m = 0.001", fine, draw_curve(fine, F, K_D, 1e-3), _near(F, K_D, 1e-3))
    for m in (0.01, 0.999, 1.0):
        yield Case(f"m = {m:g}", fine, draw_curve(fine, F, K_D, m), _near(F, K_D, m))
    for k_d in (0.0, 1e-5, 1 - 1e-5):
        yield Case(f"k_d = {k_d:g}", fine, draw_curve(fine, F, k_d, M), _near(F, k_d, M))
    yield Case("k_d = 1", fine, draw_curve(fine, F, 1.0, M), _is_matt)
    yield Case("zeros", STEPS, np.zeros(len(STEPS)), _is_dark)


def _list_refusals() -> Iterator[Case]:
    yield Case("3 points", STEPS[:3], draw_curve(STEPS[:3], F, K_D, M), None)
    yield Case("all angles equal", np.full(50, 0.4), np.linspace(1.0, 2.0, 50), None)
    yield Case("2 different angles", np.tile([0.1, 0.5], 20), np.ones(40), None)
    bins = average_bins(BECKMANN, np.linspace(0.01, 0.05, 40), np.linspace(1.0, 1.1, 40))
    yield Case("one bin of 5°", bins.angle, bins.value, None)
    yield Case("all NaN", STEPS, np.full(len(STEPS), np.nan), None)


def _near(f: float, k_d: float, m: float) -> Check:
    def measure(result: FitResult) -> float:
        v = result.values
        return float(np.max(np.abs([v["f"] / f - 1, v["k_d"] - k_d, v["m"] / m - 1])))

    return measure


def _is_finite(result: FitResult) -> float:
    p = result.parameters
    inside = p["f"].value is not None and p["f"].value >= 0 and np.isfinite(result.rss)
    return 0.0 if inside else np.inf


def _is_matt(result: FitResult) -> float:
    silent = result.parameters["m"].value is None
    return max(abs(result.values["k_d"] - 1), 0.0 if silent else np.inf)


def _is_dark(result: FitResult) -> float:
    silent = result.parameters["k_d"].value is None
    return abs(result.values["f"]) if silent else np.inf
