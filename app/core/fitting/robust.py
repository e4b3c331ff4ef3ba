"""Robust fits: points far from the curve pull less (Huber), or not at all (Tukey)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Literal, get_args

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.fitting.block import hold_pairs
from app.core.fitting.covariance import compute_covariance
from app.core.fitting.edge import arrange, solve_edge
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.projection import Projection
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.search import polish
from app.core.fitting.single import require_enough
from app.core.fitting.solve import check_fixed, make_freedom, normalise_fixed
from app.core.phase import PhaseModel, choose_model

Loss = Literal["huber", "tukey"]
# 95 % as efficient as least squares where the noise is normal.
TUNING: Mapping[Loss, float] = {"huber": 1.345, "tukey": 4.685}
NORMAL = 0.6744897501960817
"""Median of the size of a standard normal number."""
MOST_STEPS = 100
SETTLED = 1e-9
"""Of the scale: a curve that moves less has come to rest."""
PERFECT = 1e-12


def fit_robust(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    *,
    loss: Loss = "huber",
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a curve that outliers do not carry away.

    The median curve, sought over all shapes, is the start; the median size of its residuals is
    the scale and stays. At most 100 steps of least squares, each with the weights of the last
    curve's residuals, follow; Tukey's begin at Huber's curve. The order of the pairs does not
    matter.

    Parameters
    ----------
    model, angle, value, weights, fixed
        See `fit`.
    loss : ``huber`` or ``tukey``

    Returns
    -------
    FitResult
        With the `scale`; standard deviations as Huber's, Robust Statistics (1981), section 7.6.

    Raises
    ------
    WrongUse, BadInput
        As from `fit`; an unknown loss.
    """
    model = choose_model(model)
    if loss not in get_args(Loss):
        raise WrongUse(f"There is no loss {loss!r}.", f"Losses: {', '.join(get_args(Loss))}.")
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = arrange(choose_pairs(model, angle, value, weights))
    require_enough(model, pairs, len(model.parameters) - len(fixed))
    block = hold_pairs(pairs)
    normal = normalise_fixed(model, fixed, block.rows, block.scale)
    values = solve_edge(model, pairs, normal, 0.5)
    values, scale, words = _settle(model, pairs, normal, values, loss)
    miss = np.sqrt(pairs.weight) * (pairs.value - model.evaluate(pairs.angle, values))
    return report_fit(
        model,
        pairs,
        values,
        {name: float(value[0]) for name, value in normal.items()},
        partial(_covary_robust, miss=miss, scale=scale, loss=loss),
        kind=loss,
        scale=scale * pairs.scale,
        warnings=(*words, *_count_far(miss, scale, loss)),
    )


def _settle(
    model: PhaseModel,
    pairs: Pairs,
    fixed: Mapping[str, Floats],
    median: dict[str, float],
    loss: Loss,
) -> tuple[dict[str, float], float, tuple[str, ...]]:
    """From the median curve to the robust one: parameters, scale and what is to be said."""
    miss = np.sqrt(pairs.weight) * (pairs.value - model.evaluate(pairs.angle, median))
    scale = _measure_scale(miss, len(model.parameters) - len(fixed))
    if scale <= PERFECT:
        return median, scale, ("More than half of the pairs lie on one curve, which is taken.",)
    values, settled = median, True
    for each in dict.fromkeys(("huber", loss)):
        values, settled = _iterate(model, pairs, fixed, values, scale, each)
    words = () if settled else (f"The robust fit still moved after {MOST_STEPS} steps.",)
    return values, scale, words


def _measure_scale(miss: Floats, free: int) -> float:
    """σ from the median size of the residuals; as many lie on the curve as were fitted."""
    return float(np.median(np.sort(np.abs(miss))[free:])) / NORMAL


def weigh(miss: Floats, scale: float, loss: Loss) -> Floats:
    """Weight of each pair, 1 near the curve, from its weighted residual."""
    far = np.abs(miss) / (scale * TUNING[loss])
    if loss == "huber":
        return 1.0 / np.maximum(far, 1.0)
    return np.maximum(1.0 - far**2, 0.0) ** 2


def _iterate(
    model: PhaseModel,
    pairs: Pairs,
    fixed: Mapping[str, Floats],
    values: dict[str, float],
    scale: float,
    loss: Loss,
) -> tuple[dict[str, float], bool]:
    """Least squares with the weights of the last curve until it rests; whether it did."""
    freedom = make_freedom(model, fixed, 1)
    root = np.sqrt(pairs.weight)
    curve = model.evaluate(pairs.angle, values)
    scan = model.search(pairs.angle) if model.shape and model.shape not in fixed else None
    shape = values.get(model.shape, np.nan)
    for _ in range(MOST_STEPS):
        pull = weigh(root * (pairs.value - curve), scale, loss)
        both = (root * np.sqrt(pull))[None]
        full = Projection(model, pairs.angle[None], pairs.value[None], both, freedom)
        if scan is not None:
            # Where there is no specular part any shape is as good as another.
            shape = float(scan[len(scan) // 2]) if np.isnan(shape) else shape
            shape = polish(full, full, shape, (float(scan[0]), float(scan[-1])))
        found = model.name_values(
            full.solve(np.array([shape]))[0][0], shape, {k: float(v[0]) for k, v in fixed.items()}
        )
        values = {name: float(value) for name, value in found.items()}
        after = model.evaluate(pairs.angle, values)
        moved = float((root * np.abs(after - curve)).max())
        curve = after
        if moved <= SETTLED * scale:
            return values, True
    return values, False


def _covary_robust(jacobian: Floats, miss: Floats, scale: float, loss: Loss) -> Floats:
    """K²·Σψ²/(n − p)/(mean ψ')²·(JᵀJ)⁻¹ with Huber's correction K for few pairs."""
    n, p = jacobian.shape
    if scale <= PERFECT:
        return compute_covariance(jacobian, float(np.sqrt((miss**2).sum() / max(n - p, 1))))
    far = np.abs(miss) / (scale * TUNING[loss])
    pull = miss * weigh(miss, scale, loss)
    bend = np.where(far <= 1, 1.0 if loss == "huber" else (1 - far**2) * (1 - 5 * far**2), 0.0)
    mean = float(bend.mean())
    if mean <= 0.0:
        return np.full((p, p), np.nan)
    few = 1 + p / n * float(bend.var()) / mean**2
    noise = few * float(np.sqrt((pull**2).sum() / (n - p))) / mean
    return compute_covariance(jacobian, noise)


def _count_far(miss: Floats, scale: float, loss: Loss) -> tuple[str, ...]:
    count = int((np.abs(miss) > TUNING[loss] * scale).sum()) if scale > PERFECT else 0
    what = "pull less" if loss == "huber" else "do not count"
    far = f"{TUNING[loss]:g} σ or more from the curve {what}."
    return (f"{count} of {len(miss)} pairs {far}",) if count else ()
