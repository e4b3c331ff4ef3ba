"""Every model of the registry: its parameters found again, and a second opinion on them."""

from __future__ import annotations

import numpy as np

from app.core.fitting import fit, fit_many
from app.core.fitting.trust_region import fit_trust_region
from app.core.phase import MODELS, PhaseModel
from app.core.progress import QUIET, Progress
from app.services.bench.fit.curves import STEPS
from app.services.bench.results import ResultTable, Value

DRAWS, QUICK_DRAWS = 200, 20
OPINIONS, QUICK_OPINIONS = 20, 3
NOISE = 0.02
NOTE = (
    "Random parameters from the usual ranges, 17 angles of 0 to 80°. error: largest difference of "
    "a parameter found in the exact curve, of its usual range. The second opinion is SciPy's "
    "trust-region search from the model's start values, on curves with 2 % noise: missed where "
    "its sum of squares is above ours by more than 1e-6 of it; better where it is below by more "
    "than 1e-9 of it."
)


def recover_models(quick: bool, progress: Progress = QUIET) -> ResultTable:
    """One row for each model."""
    rows = []
    for place, model in enumerate(MODELS.values()):
        progress.report(place / len(MODELS), model.title)
        rows.append(_recover(model, quick))
    return ResultTable("fit_models", "Parameters found again", rows, NOTE)


def _recover(model: PhaseModel, quick: bool) -> dict[str, Value]:
    rng = np.random.default_rng(5)
    draws = [model.random(rng) for _ in range(QUICK_DRAWS if quick else DRAWS)]
    curves = np.array([model.evaluate(STEPS, values) for values in draws])
    true = np.array([list(values.values()) for values in draws])
    width = np.array([np.ptp(p.typical) for p in model.parameters])
    batch = fit_many(model, STEPS, curves)
    missed = better = 0
    opinions = QUICK_OPINIONS if quick else OPINIONS
    for curve in curves[:opinions]:
        noisy = curve + NOISE * rng.standard_normal(len(STEPS))
        ours, theirs = fit(model, STEPS, noisy).rss, fit_trust_region(model, STEPS, noisy).rss
        missed += int(theirs > ours * (1 + 1e-6))
        better += int(theirs < ours * (1 - 1e-9))
    return {
        "model": model.name,
        "curves": len(draws),
        "error": float(f"{np.abs((batch.values - true) / width).max():.3g}"),
        "opinions": opinions,
        "missed": missed,
        "better": better,
    }
