"""Time against error: our fit and what else one might do with the same curves."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np

from app.core.arrays import Floats
from app.core.fitting import fit, fit_many
from app.core.fitting.trust_region import fit_trust_region
from app.core.progress import QUIET, Progress
from app.services.bench.fit.curves import BECKMANN, START, STEPS, fit_with_scipy, make_curves
from app.services.bench.results import ResultTable, Value

CURVES, QUICK_CURVES = 200, 20
NOISES = (0.0035, 0.06, 0.2)
LEAST = 1e-16
OURS = ("fit_many", "fit, one by one")
NOTE = (
    "Lambert–Beckmann, 17 angles. excess: sum of squares above the least of all ways, of Σy²; the "
    "mean, and the largest. curve_fit with bounds, from one start or the best of several."
)
Way = Callable[[Floats], Floats]


def _loop(solve: Callable[[Floats], float]) -> Way:
    return lambda values: np.array([solve(row) for row in values])


def _from_starts(count: int) -> Way:
    rng = np.random.default_rng(4)
    starts = [START, *(np.column_stack((rng.uniform(0.2, 2, 19), rng.uniform(0, 1, 19),
                                        rng.uniform(0.05, 1, 19))))][:count]  # fmt: skip

    def solve(row: Floats) -> float:
        return min(fit_with_scipy(STEPS, row, start)[1] for start in starts)

    return _loop(solve)


WAYS: Mapping[str, Way] = {
    "fit_many": lambda values: fit_many(BECKMANN, STEPS, values).rss,
    "fit, one by one": _loop(lambda row: fit(BECKMANN, STEPS, row).rss),
    "trust region, exact Jacobian": _loop(lambda row: fit_trust_region(BECKMANN, STEPS, row).rss),
    "curve_fit, 1 start": _from_starts(1),
    "curve_fit, 3 starts": _from_starts(3),
    "curve_fit, 10 starts": _from_starts(10),
}


def measure_trade(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """Rows: noise × way, with time and excess."""
    rows: list[dict[str, Value]] = []
    for place, noise in enumerate(NOISES):
        value = make_curves(QUICK_CURVES if quick else CURVES, 8, noise).value
        taken, rss = {}, {}
        for turn, (name, way) in enumerate(WAYS.items()):
            progress.report((place + turn / len(WAYS)) / len(NOISES), name)
            start = time.perf_counter()
            rss[name] = way(value)
            taken[name] = (time.perf_counter() - start) / len(value)
        best = np.min(list(rss.values()), axis=0)
        for name in WAYS:
            excess = (rss[name] - best) / (value**2).sum(axis=1)
            rows.append({
                "noise_percent": round(100 * noise, 6),
                "way": name,
                "ms_per_fit": float(f"{1e3 * taken[name]:.4g}"),
                "mean_excess": float(f"{excess.mean():.3g}"),
                "largest_excess": float(f"{excess.max():.3g}"),
            })  # fmt: skip
    return ResultTable("fit_trade", "Time and excess error", rows, NOTE)
