"""From the best curve to a result: errors, quality, and the reasons for what is missing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.fitting.covariance import compute_covariance
from app.core.fitting.open_sides import explain_open_sides
from app.core.fitting.pairs import Pairs
from app.core.fitting.result import Estimate, FitResult
from app.core.phase import Parameter, PhaseModel
from app.core.phase.angular import AngularModel

Covary = Callable[[Floats], Floats]
# Values that differ by less than this share of their size are equal.
EQUAL = 1e-14


def report_fit(
    model: AngularModel,
    pairs: Pairs,
    values: dict[str, float],
    fixed: Mapping[str, float],
    covary: Covary | None = None,
    **more: Any,
) -> FitResult:
    """Describe the curve with these parameters beside the pairs that it was fitted to.

    Parameters
    ----------
    model : AngularModel
    pairs : Pairs
    values : dict of str to float
        Parameters for the normalised values; NaN for an undetermined one.
    fixed : mapping of str to float
        Those that were not fitted.
    covary : callable, optional
        Covariance, (p, p), from the weighted Jacobian, (n, p); by default that of least squares.
    **more
        Other attributes of the result; `warnings` are put before the model's own.
    """
    free = [p for p in model.parameters if p.name not in fixed]
    squares = covary is None
    misses = pairs.value - model.evaluate(pairs.angle, values)
    rss = float((pairs.weight * misses**2).sum())
    spare = len(pairs) - len(free)
    covary = covary or partial(compute_covariance, noise=float(np.sqrt(rss / spare)))
    covariance = _covary(model, pairs, values, free, covary)
    in_units = {p.name: values[p.name] * _size(p, pairs) for p in model.parameters}
    scatter = float(np.sqrt((misses**2).sum() / spare)) * pairs.scale
    deviations = {name: row[name] ** 0.5 for name, row in covariance.items()}
    return FitResult(
        model=model.name,
        n=len(pairs),
        parameters={
            p.name: _estimate(p, pairs, values[p.name], deviations.get(p.name, np.nan), p in free)
            for p in model.parameters
        },
        rss=rss * pairs.scale**2 * pairs.weight_scale,
        rmse=float(np.sqrt(rss / pairs.weight.sum())) * pairs.scale,
        r2=_explain(pairs, rss),
        angle_range=(float(pairs.angle.min()), float(pairs.angle.max())),
        warnings=(
            *pairs.warnings,
            *more.pop("warnings", ()),
            *_explain_missing(model, values, free, deviations),
            *(_explain_held(model, free, deviations) if squares else ()),
            *(_explain_open(model, pairs, values, rss, deviations, fixed) if squares else ()),
            *model.remark(in_units, pairs.angle, scatter, fixed),
        ),
        covariance=_scale_covariance(model, pairs, covariance),
        **more,
    )


def _size(p: Parameter, pairs: Pairs) -> float:
    return pairs.scale if p.scales else 1.0


def _explain(pairs: Pairs, rss: float) -> float | None:
    mean = (pairs.weight * pairs.value).sum() / pairs.weight.sum()
    total = float((pairs.weight * (pairs.value - mean) ** 2).sum())
    return 1.0 - rss / total if total > EQUAL**2 * pairs.weight.sum() else None


def _covary(
    model: AngularModel,
    pairs: Pairs,
    values: dict[str, float],
    free: Sequence[Parameter],
    covary: Covary,
) -> dict[str, dict[str, float]]:
    """Covariance of the parameters that lie inside their bounds, the others held.

    Those that the data do not determine are left out.
    """
    names = [
        p.name for p in free if np.isfinite(values[p.name]) and not p.touches_bound(values[p.name])
    ]
    if not names:
        return {}
    root: Floats = np.sqrt(pairs.weight)[:, None]
    jacobian = model.jacobian(pairs.angle, values, names) * root
    # Where μ is undetermined nothing tells how the curve changes with A.
    seen: Bools = np.isfinite(jacobian).all(axis=0) & (jacobian != 0.0).any(axis=0)
    if not seen.any():
        return {}
    names = [name for name, one in zip(names, seen, strict=True) if one]
    matrix = covary(jacobian[:, seen])
    known = np.flatnonzero(np.isfinite(np.diagonal(matrix)))
    return {names[i]: {names[j]: float(matrix[i, j]) for j in known} for i in known}


def _scale_covariance(
    model: AngularModel, pairs: Pairs, covariance: dict[str, dict[str, float]]
) -> dict[str, dict[str, float]]:
    sizes = {p.name: _size(p, pairs) for p in model.parameters}
    return {
        a: {b: value * sizes[a] * sizes[b] for b, value in row.items()}
        for a, row in covariance.items()
    }


def _estimate(p: Parameter, pairs: Pairs, value: float, sd: float, free: bool) -> Estimate:
    size = _size(p, pairs)
    known = bool(np.isfinite(value))
    return Estimate(
        value * size if known else None,
        sd * size if np.isfinite(sd) else None,
        p.unit,
        bool(free and known and p.touches_bound(value)),
        not free,
    )


def _explain_open(
    model: AngularModel,
    pairs: Pairs,
    values: Mapping[str, float],
    rss: float,
    deviations: Mapping[str, float],
    fixed: Mapping[str, float],
) -> list[str]:
    if not isinstance(model, PhaseModel) or model.shape not in deviations:
        return []
    return explain_open_sides(model, pairs, values, rss, deviations[model.shape], fixed)


def _explain_held(
    model: AngularModel, free: Sequence[Parameter], deviations: Mapping[str, float]
) -> list[str]:
    """A sentence where standard deviations hold what may move, at a bound or undetermined."""
    known = [p.name for p in free if p.name in deviations]
    held = [p.name for p in free if p.name not in deviations]
    if not (known and held):
        return []
    one = len(known) == 1
    cure = ": ask for profile intervals" if isinstance(model, PhaseModel) else ""
    return [
        f"The standard deviation{'' if one else 's'} of {_join(known)}"
        f" take{'s' if one else ''} {_join(held)} as known{cure}."
    ]


def _join(names: Sequence[str]) -> str:
    """``f``, ``f and k_d``, ``a, b and c``."""
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def _explain_missing(
    model: AngularModel,
    values: dict[str, float],
    free: Sequence[Parameter],
    deviations: dict[str, float],
) -> list[str]:
    """One sentence for each parameter without a value or without a standard deviation."""
    sentences = []
    for p in model.parameters:
        if p not in free:
            sentences.append(f"{p.name} was held fixed.")
        elif not np.isfinite(values[p.name]):
            why = model.unknown_when.get(p.name, "the data say nothing about it")
            sentences.append(f"{p.name} is undetermined: {why}.")
        elif p.touches_bound(values[p.name]):
            sentences.append(f"{p.name} is at its bound and has no standard deviation.")
        elif p.name not in deviations:
            sentences.append(f"{p.name} has no standard deviation: the data do not determine it.")
    return sentences
