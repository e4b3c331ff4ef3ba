"""Which model: information criteria side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.fitting.result import FitResult
from app.core.fitting.single import AnyModel, fit
from app.core.phase import get_model
from app.core.progress import QUIET, Progress


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
    weight : float or None
        Akaike weight from AICc: how likely the model is the best of these.
    """

    model: str
    result: FitResult | None
    words: tuple[str, ...]
    aic_above: float | None
    aicc_above: float | None
    bic_above: float | None
    weight: float | None


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
    found: list[FitResult | str] = []
    for number, model in enumerate(known):
        progress.report(number / len(known), f"Fitting {model.title}")
        try:
            found.append(fit(model, angle[common], value[common], weights=weights))
        except BadInput as error:
            found.append(str(error))
    above = {name: _measure(found, name) for name in ("aic", "aicc", "bic")}
    shares = _weigh(above["aicc"])
    return tuple(
        Comparison(
            model.name,
            one if isinstance(one, FitResult) else None,
            one.warnings if isinstance(one, FitResult) else (one,),
            above["aic"][place],
            above["aicc"][place],
            above["bic"][place],
            shares[place],
        )
        for place, (model, one) in enumerate(zip(known, found, strict=True))
    )


def _measure(found: Sequence[FitResult | str], name: str) -> list[float | None]:
    values = [getattr(one, name) if isinstance(one, FitResult) else None for one in found]
    least = min((v for v in values if v is not None), default=0.0)
    return [None if v is None else v - least for v in values]


def _weigh(above: Sequence[float | None]) -> list[float | None]:
    likely = [None if v is None else float(np.exp(-v / 2)) for v in above]
    total = sum(v for v in likely if v is not None)
    return [None if v is None else v / total for v in likely]
