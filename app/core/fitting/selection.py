"""Which model: information criteria side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.result import FitResult
from app.core.fitting.single import AnyModel, fit
from app.core.phase import get_model
from app.core.progress import QUIET, Progress

# Of the values' root mean square: a curve that misses them by less is exact.
EXACT = 1e-10


@dataclass(frozen=True, slots=True)
class Comparison:
    """One model among others on the same pairs.

    Attributes
    ----------
    model : str
    result : FitResult or None
        None where the model cannot be fitted; `words` tells why.
    words : tuple of str
    aic_above, aicc_above, bic_above : float or None
        How far the criterion is above the least of all models; below 2 there is no preference.
        None for all where a model is exact, and AICc also where a model is crowded.
    weight : float or None
        Akaike weight from AICc: how likely the model is the best of these.
    best : bool
        The one with the least AICc; of exact models the one with the fewest parameters.
    exact : bool
        It runs through all pairs but for rounding, where criteria cannot rank.
    crowded : bool
        It has too many parameters for so few pairs: there is no AICc, so no fair comparison.
    """

    model: str
    result: FitResult | None
    words: tuple[str, ...]
    aic_above: float | None
    aicc_above: float | None
    bic_above: float | None
    weight: float | None
    best: bool
    exact: bool
    crowded: bool


def compare_models(
    models: Sequence[AnyModel | str],
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    progress: Progress = QUIET,
) -> tuple[Comparison, ...]:
    """Fit several models to the same pairs: those that every one of them accepts.

    Parameters
    ----------
    models : sequence of PhaseModel, FormulaModel or str
    angle, value, weights
        See `fit`.
    progress : Progress

    Notes
    -----
    AIC = n·ln(rss/n) + 2k and BIC with k·ln n, k counting σ too; AICc adds 2k(k+1)/(n−k−1).
    Burnham and Anderson, Model Selection (2002), chapter 2. Constants that all models share
    are left out.
    """
    known = [get_model(model) if isinstance(model, str) else model for model in models]
    angle, value = (np.asarray(array, np.float64).ravel() for array in (angle, value))
    common: Bools = np.logical_and.reduce([model.accepts(angle) for model in known])
    weights = None if weights is None else np.asarray(weights, np.float64).ravel()[common]
    pairs = choose_pairs(known[0], angle[common], value[common], weights)
    found: list[FitResult | str] = []
    for number, model in enumerate(known):
        progress.report(number / len(known), f"Fitting {model.title}")
        try:
            found.append(fit(model, angle[common], value[common], weights=weights))
        except BadInput as error:
            found.append(str(error))
    return _rank(known, found, pairs)


def _rank(
    models: Sequence[AnyModel], found: Sequence[FitResult | str], pairs: Pairs
) -> tuple[Comparison, ...]:
    counts = [len(model.parameters) for model in models]
    crowded = [len(pairs) <= count + 2 for count in counts]
    exact = [isinstance(one, FitResult) and _is_exact(one, pairs) for one in found]
    above = {name: _measure(found, name, exact) for name in ("aic", "aicc", "bic")}
    if any(crowded):
        above["aicc"] = [None] * len(found)
    shares = _weigh(above["aicc"])
    best = _choose_best(above["aicc"], exact, counts)
    return tuple(
        Comparison(
            model=model.name,
            result=one if isinstance(one, FitResult) else None,
            words=one.warnings if isinstance(one, FitResult) else (one,),
            aic_above=above["aic"][place],
            aicc_above=above["aicc"][place],
            bic_above=above["bic"][place],
            weight=shares[place],
            best=place == best,
            exact=exact[place],
            crowded=crowded[place],
        )
        for place, (model, one) in enumerate(zip(models, found, strict=True))
    )


def _is_exact(result: FitResult, pairs: Pairs) -> bool:
    size = float((pairs.weight * pairs.value**2).sum()) * pairs.scale**2 * pairs.weight_scale
    return result.rss <= EXACT**2 * size


def _choose_best(
    above: Sequence[float | None], exact: Sequence[bool], counts: Sequence[int]
) -> int | None:
    """Place of the simplest exact model where only one is so simple, else of the least AICc."""
    if any(exact):
        fewest = min(count for count, one in zip(counts, exact, strict=True) if one)
        simplest = [place for place, one in enumerate(exact) if one and counts[place] == fewest]
        return simplest[0] if len(simplest) == 1 else None
    return next((place for place, one in enumerate(above) if one == 0.0), None)


def _measure(
    found: Sequence[FitResult | str], name: str, exact: Sequence[bool]
) -> list[float | None]:
    """Differences to the least; none where a curve is exact, of which the criterion is −∞."""
    if any(exact):
        return [None] * len(found)
    values = [getattr(one, name) if isinstance(one, FitResult) else None for one in found]
    least = min((v for v in values if v is not None), default=0.0)
    return [None if v is None else v - least for v in values]


def _weigh(above: Sequence[float | None]) -> list[float | None]:
    likely = [None if v is None else float(np.exp(-v / 2)) for v in above]
    total = sum(v for v in likely if v is not None)
    return [None if v is None else v / total for v in likely]
