"""Fit one angular model to one set of pairs of angle and value."""

from __future__ import annotations

from collections.abc import Mapping

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.fitting.block import hold_pairs
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.solve import check_fixed, normalise_fixed, solve_block
from app.core.phase import PhaseModel, get_model
from app.core.phase.angular import AngularModel
from app.core.phase.formula_model import FormulaModel

AnyModel = PhaseModel | FormulaModel


def fit(
    model: AnyModel | str,
    angle: Floats,
    value: Floats,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Find the parameters with the least sum of squares, over all of their bounds.

    Parameters
    ----------
    model : PhaseModel, FormulaModel or str
        A formula is fitted as `app.core.fitting.formula_fit` says.
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
        Variable projection with the model's columns; covariance from the Jacobian.

    Raises
    ------
    WrongUse
        Unknown model, or a fixed parameter that does not exist or lies outside its bounds.
    BadInput
        Not more pairs than parameters, or too few different angles.
    """
    model = get_model(model) if isinstance(model, str) else model
    if isinstance(model, FormulaModel):
        from app.core.fitting.formula_fit import fit_formula

        return fit_formula(model, angle, value, weights=weights, fixed=fixed)
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = choose_pairs(model, angle, value, weights)
    require_enough(model, pairs, len(model.parameters) - len(fixed))
    return fit_pairs(model, pairs, fixed)


def fit_pairs(model: PhaseModel, pairs: Pairs, fixed: Mapping[str, float]) -> FitResult:
    """Fit pairs that were found to be enough; see `fit`."""
    block = hold_pairs(pairs)
    normal = normalise_fixed(model, fixed, block.rows, block.scale)
    solved = solve_block(model, block, normal)
    return report_fit(
        model,
        pairs,
        {name: float(value[0]) for name, value in solved.values.items()},
        {name: float(value[0]) for name, value in normal.items()},
    )


def require_enough(model: AngularModel, pairs: Pairs, free: int) -> None:
    """Raise `BadInput` where the pairs cannot tell `free` parameters."""
    left_out = " ".join(pairs.warnings)
    if len(pairs) <= free:
        raise BadInput(
            f"{model.name} needs more pairs than free parameters, {free}; there are {len(pairs)}.",
            left_out,
        )
    angles = int(hold_pairs(pairs).count_angles(max(free, 2))[0])
    if angles == 1:
        raise BadInput("All angles are equal: they say nothing about the angle.", left_out)
    if angles < free:
        raise BadInput(
            f"{model.name} needs as many different angles as free parameters, {free}; there are"
            f" {angles}.",
            left_out,
        )
