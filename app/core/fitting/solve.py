"""Fit one angular model to pairs of angle and value."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.projection import project
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.phase import PhaseModel, get_model


def fit(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Find the parameters with the least sum of squares, over all of their bounds.

    Parameters
    ----------
    model : PhaseModel or str
    angle : (n,) array
        Radians. Pairs that are not finite or outside the model's angles are left out and counted
        in the warnings.
    value : (n,) array
        Intensity, reflectance or index.
    weights : (n,) array, optional
        1/σ², or counts of points behind a mean.
    fixed : mapping of str to float, optional
        Parameters that are not to be fitted.

    Returns
    -------
    FitResult
        Variable projection with the model's columns; standard deviations from the Jacobian.

    Raises
    ------
    WrongUse
        Unknown model, or a fixed parameter that does not exist or lies outside its bounds.
    BadInput
        Not more pairs than parameters, or too few different angles.
    """
    model = get_model(model) if isinstance(model, str) else model
    fixed = _check_fixed(model, dict(fixed or {}))
    pairs = choose_pairs(model, angle, value, weights)
    _require_enough(model, pairs, len(model.parameters) - len(fixed))
    normal = {
        p.name: fixed[p.name] / pairs.scale if p.scales else fixed[p.name]
        for p in model.parameters
        if p.name in fixed
    }
    coefficients, shape = project(model, pairs, model.free(normal), normal)
    values = model.name_values(coefficients, shape, normal)
    return report_fit(model, pairs, values, normal)


def _check_fixed(model: PhaseModel, fixed: dict[str, float]) -> dict[str, float]:
    known = {p.name: p for p in model.parameters}
    for name, value in fixed.items():
        if name not in known:
            names = ", ".join(known)
            raise WrongUse(f"{model.name} has no parameter {name!r}.", f"Parameters: {names}.")
        low, high = known[name].lower, known[name].upper
        if not (np.isfinite(value) and low <= value <= high):
            raise WrongUse(f"{name} = {value:g} is outside its bounds, {low:g} to {high:g}.")
    return fixed


def _require_enough(model: PhaseModel, pairs: Pairs, free: int) -> None:
    left_out = " ".join(pairs.warnings)
    if len(pairs) <= free:
        raise BadInput(
            f"{model.name} needs more pairs than free parameters, {free}; there are {len(pairs)}.",
            left_out,
        )
    angles = len(np.unique(pairs.angle))
    if angles == 1:
        raise BadInput("All angles are equal: they say nothing about the angle.", left_out)
    if angles < free:
        raise BadInput(
            f"{model.name} needs as many different angles as free parameters, {free}; there are"
            f" {angles}.",
            left_out,
        )
