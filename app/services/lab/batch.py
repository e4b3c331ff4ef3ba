"""Many sets of pairs fitted the same way in one call: leaves × channels, groups of a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.core.chunks import count_processors
from app.core.errors import BadInput
from app.core.fitting import FitResult, fit_many
from app.core.fitting.bins import BinMeans, average_bins, tell_bins
from app.core.phase import PhaseModel
from app.core.phase.formula_model import FormulaModel
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.services.lab.method import Method, choose_pairs, fit_by, require_fit
from app.services.lab.own_models import AnyModel, find_model

Pairs = tuple[Floats, Floats]
SOLVED = 0.9
"""Share of the progress after which only the words are missing."""


def fit_sets(
    sets: Sequence[Pairs],
    model: AnyModel,
    method: Method,
    fixed: Mapping[str, float] | None = None,
    progress: Progress = QUIET,
) -> list[FitResult | BadInput]:
    """Fit each set of angles (degrees) and values; one that cannot be does not stop the others.

    Least squares of a model of the registry are one batch; all else is fitted set by set.

    Parameters
    ----------
    sets : sequence of (angles, values)
    model, method, fixed
        See `app.services.lab.method.fit_by`.
    progress : Progress

    Raises
    ------
    WrongUse
        Unknown model or parameter, or a model that the method does not suit.
    Cancelled
    """
    known = find_model(model)
    require_fit(method, known)
    if not sets:
        return []
    if isinstance(known, PhaseModel) and method.by_squares:
        return _fit_batch(sets, known, method, fixed, progress)
    return _fit_apart(sets, known, method, fixed, progress)


def _fit_batch(
    sets: Sequence[Pairs],
    model: PhaseModel,
    method: Method,
    fixed: Mapping[str, float] | None,
    progress: Progress,
) -> list[FitResult | BadInput]:
    chosen = [choose_pairs(method, angle, value) for angle, value in sets]
    words = [sentence for _, _, sentence in chosen]
    pairs: list[Pairs] = [(angle, value) for angle, value, _ in chosen]
    width = float(to_radians(method.width))
    means: list[BinMeans] = []
    weights = None
    if method.to == "bins":
        means = [average_bins(model, angle, value, width) for angle, value in pairs]
        pairs = [(each.angle, each.value) for each in means]
        known = [np.ones(len(m.count)) if m.weights is None else m.weights for m in means]
        weights = np.concatenate(known)
    borders = np.cumsum([0, *(len(angle) for angle, _ in pairs)])
    angle, value = (np.concatenate(column) for column in zip(*pairs, strict=True))
    part = progress.part(0.0, SOLVED)
    batch = fit_many(model, angle, value, weights, offsets=borders, fixed=fixed, progress=part)
    found: list[FitResult | BadInput] = []
    for place, sentence in enumerate(words):
        progress.report(SOLVED + (1 - SOLVED) * place / len(words), f"Fitting {model.title}")
        try:
            result = batch.result(place)
        except BadInput as error:
            found.append(error)
            continue
        result = tell_bins(result, means[place], width) if means else result
        found.append(replace(result, warnings=(*sentence, *result.warnings)))
    return found


def _fit_apart(
    sets: Sequence[Pairs],
    model: PhaseModel | FormulaModel,
    method: Method,
    fixed: Mapping[str, float] | None,
    progress: Progress,
) -> list[FitResult | BadInput]:
    def fit_one(pairs: Pairs) -> FitResult | BadInput:
        try:
            return fit_by(method, model, *pairs, fixed=fixed)
        except BadInput as error:
            return error

    found: list[FitResult | BadInput] = []
    text = f"Fitting {model.title}"
    progress.report(0.0, text)
    with ThreadPoolExecutor(max(1, min(count_processors(), len(sets)))) as pool:
        try:
            for done in pool.map(fit_one, sets):
                found.append(done)
                progress.report(len(found) / len(sets), text)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return found
