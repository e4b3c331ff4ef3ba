"""Fits of formula models: trust-region searches from the best of many deterministic starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.fitting.pairs import Pairs, choose_pairs, condense
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.single import require_enough
from app.core.fitting.solve import MOST_SEARCHED, check_fixed
from app.core.fitting.trust_region import search_minimum
from app.core.phase import Parameter
from app.core.phase.formula_model import FormulaModel

# Points that are looked at, and those of them from which a search starts.
TRIALS, STARTS = 400, 12


def fit_formula(
    model: FormulaModel,
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a user's formula within its bounds.

    400 points spread evenly over the bounds, or over the usual range where there are none, are
    looked at; searches start from the best 12, in means per bin where there are many pairs, and
    the best ends in all pairs. Likely, but not sure, to be the best curve there is.

    Parameters
    ----------
    model : FormulaModel
    angle, value, weights, fixed
        See `fit`.

    Raises
    ------
    WrongUse, BadInput
        As from `fit`; the formula has no finite value at the fitted angles.
    """
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = choose_pairs(model, angle, value, weights)
    if not model.is_scaled:
        pairs = Pairs(
            pairs.angle, pairs.value * pairs.scale, pairs.weight, 1.0, pairs.weight_scale,
            pairs.warnings,
        )  # fmt: skip
    free = [p for p in model.parameters if p.name not in fixed]
    require_enough(model, pairs, len(free))
    sizes = {p.name: pairs.scale if p.scales else 1.0 for p in model.parameters}
    normal = {name: number / sizes[name] for name, number in fixed.items()}
    few = condense(pairs, MOST_SEARCHED)
    ends = [
        search_minimum(model, few, free, start)
        for start in _choose_starts(model, few, free, normal)
    ]
    if not ends:
        raise BadInput("The formula has no finite value at the fitted angles.", model.formula)
    best = min(ends, key=lambda end: end[1])[0]
    values = best if few is pairs else search_minimum(model, pairs, free, best)[0]
    return report_fit(model, pairs, values, normal, formula=model.definition)


def _choose_starts(
    model: FormulaModel, pairs: Pairs, free: Sequence[Parameter], fixed: Mapping[str, float]
) -> list[dict[str, float]]:
    """The points with the least sums of squares, of those with finite curves."""
    points = [
        {**fixed, **dict(zip((p.name for p in free), map(float, row), strict=True))}
        for row in _spread(free)
    ]
    rss = np.array([_measure(model, pairs, point) for point in points])
    order = np.argsort(rss, kind="stable")[:STARTS]
    return [points[place] for place in order if np.isfinite(rss[place])]


def _measure(model: FormulaModel, pairs: Pairs, values: Mapping[str, float]) -> float:
    miss = pairs.value - model.evaluate(pairs.angle, values)
    rss = float((pairs.weight * miss**2).sum())
    return rss if np.isfinite(rss) else np.inf


def _spread(free: Sequence[Parameter]) -> Floats:
    """Points even over a box, (t, p): the additive recurrence with the generalised golden ratio.

    Roberts (2018), "The unreasonable effectiveness of quasirandom sequences".
    """
    golden = 2.0
    for _ in range(60):
        golden = (1.0 + golden) ** (1.0 / (len(free) + 1))
    steps = golden ** -np.arange(1.0, len(free) + 1)
    unit = (0.5 + np.arange(TRIALS)[:, None] * steps) % 1.0
    low, high = np.array([_find_box(p) for p in free]).T
    return np.asarray(low + unit * (high - low))


def _find_box(p: Parameter) -> tuple[float, float]:
    bounded = bool(np.isfinite(p.upper - p.lower)) and not p.scales
    return (p.lower, p.upper) if bounded else p.typical
