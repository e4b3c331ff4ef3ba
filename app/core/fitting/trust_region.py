"""A second opinion: all parameters at once by SciPy's trust-region search with bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from app.core.arrays import Floats
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.single import require_enough
from app.core.fitting.solve import check_fixed
from app.core.phase import Parameter, PhaseModel, choose_model
from app.core.phase.angular import AngularModel

TOLERANCE = 1e-15
MOST_EVALUATIONS = 500
# Share of the range by which a start keeps away from a bound, where the search would stick.
MARGIN = 1e-6


def fit_trust_region(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit as most programs do: from a start value, to the nearest minimum.

    Independent of `fit` in everything but the model's curve and Jacobian.

    Parameters
    ----------
    model, angle, value, weights, fixed
        See `fit`.
    start : mapping of str to float, optional
        By default the model's start values for data of this size.

    Raises
    ------
    WrongUse, BadInput
        As from `fit`.

    Notes
    -----
    Branch, Coleman and Li, SIAM J. Sci. Comput. 21 (1999) 1: trust-region reflective.
    """
    model = choose_model(model)
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = choose_pairs(model, angle, value, weights)
    free = [p for p in model.parameters if p.name not in fixed]
    require_enough(model, pairs, len(free))
    normal = {name: _divide(model, name, value, pairs.scale) for name, value in fixed.items()}
    begin = model.start_values() | {
        name: _divide(model, name, value, pairs.scale) for name, value in (start or {}).items()
    }
    values, _ = search_minimum(model, pairs, free, begin | normal)
    shape = values.get(model.shape, np.nan)
    named = model.name_values(model.coefficients(values), shape, normal)
    plain = {name: float(value) for name, value in named.items()}
    return report_fit(model, pairs, plain, normal, kind="trust region")


def search_minimum(
    model: AngularModel, pairs: Pairs, free: Sequence[Parameter], start: Mapping[str, float]
) -> tuple[dict[str, float], float]:
    """Parameters of the normalised values at the minimum next to `start`, and its rss."""
    from scipy.optimize import least_squares

    names = [p.name for p in free]
    root = np.sqrt(pairs.weight)

    def miss(trial: Floats) -> Floats:
        curve = model.evaluate(pairs.angle, {**start, **dict(zip(names, trial, strict=True))})
        return root * (curve - pairs.value)

    def bend(trial: Floats) -> Floats:
        values = {**start, **dict(zip(names, trial, strict=True))}
        return root[:, None] * model.jacobian(pairs.angle, values, names)

    begin = np.array([_keep_inside(p, start[p.name]) for p in free])
    bounds = np.array([(p.lower, p.upper) for p in free]).T
    found = least_squares(
        miss, begin, bend, (bounds[0], bounds[1]), x_scale="jac", max_nfev=MOST_EVALUATIONS,
        xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE,
    )  # fmt: skip
    return {**start, **dict(zip(names, map(float, found.x), strict=True))}, float(2 * found.cost)


def _keep_inside(p: Parameter, value: float) -> float:
    width = p.upper - p.lower
    margin = MARGIN * (width if np.isfinite(width) else 1.0)
    return float(np.clip(value, p.lower + margin, p.upper - margin))


def _divide(model: PhaseModel, name: str, value: float, scale: float) -> float:
    scaled = {p.name: p.scales for p in model.parameters}
    return value / scale if scaled.get(name) else value
