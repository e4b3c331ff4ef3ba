"""Fit one curve the way a user chose; degrees outside, radians inside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.fitting import FitResult, fit
from app.core.phase import PhaseModel
from app.core.phase.angular import AngularModel
from app.core.phase.formula_model import FormulaModel
from app.core.units import to_radians
from app.model.fit_method import RIGHT_ANGLE_DEG, WHOLE_SCAN, Method, usual_method
from app.services.lab.own_models import AnyModel, find_model

__all__ = ["WHOLE_SCAN", "Method", "choose_pairs", "describe_method", "fit_by", "usual_method"]

ALL_ANGLES = (0.0, RIGHT_ANGLE_DEG)


def fit_by(
    method: Method,
    model: AnyModel,
    angle_deg: Floats,
    value: Floats,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit a curve to pairs.

    Parameters
    ----------
    method : Method
    model : str, AngularModel or FormulaDefinition
        See `app.services.lab.own_models.find_model`.
    angle_deg, value : (n,) arrays
    fixed : mapping of str to float, optional
        Parameters that are not fitted.

    Raises
    ------
    WrongUse
        Unknown model or parameter, or a formula that is to be fitted otherwise than by squares.
    BadInput
        Too few pairs or angles, as `app.core.fitting.fit` says.
    """
    known = find_model(model)
    require_fit(method, known)
    angle, chosen, words = choose_pairs(method, angle_deg, value)
    result = _fit(method, known, angle, chosen, fixed)
    return replace(result, warnings=(*words, *result.warnings)) if words else result


def _fit(
    method: Method,
    model: PhaseModel | FormulaModel,
    angle: Floats,
    value: Floats,
    fixed: Mapping[str, float] | None,
) -> FitResult:
    if method.to == "bins":
        from app.core.fitting.bins import fit_bins

        return fit_bins(model, angle, value, width=float(to_radians(method.width)), fixed=fixed)
    if isinstance(model, FormulaModel) or method.by_squares:
        return fit(model, angle, value, fixed=fixed)
    if method.to == "edge":
        from app.core.fitting.edge import fit_edge

        return fit_edge(model, angle, value, tau=method.tau, fixed=fixed)
    from app.core.fitting.robust import Loss, fit_robust

    loss: Loss = "huber" if method.loss == "huber" else "tukey"
    return fit_robust(model, angle, value, loss=loss, fixed=fixed)


def require_fit(method: Method, model: AngularModel) -> None:
    """Raise `WrongUse` where a model cannot be fitted by a method."""
    if isinstance(model, FormulaModel) and not method.by_squares:
        raise WrongUse(
            f"The formula {model.name} can be fitted to points or to means, by least squares only.",
            "Choose one of these, or a model of the list.",
        )


def choose_pairs(
    method: Method, angle_deg: Floats, value: Floats
) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Pairs within the method's angles, the angles in radians; a sentence on those left out.

    Angles that no model is defined for stay where the method takes all angles: the fit counts
    them.
    """
    angle_deg, value = np.asarray(angle_deg, np.float64), np.asarray(value, np.float64)
    if method.angles == ALL_ANGLES:
        return to_radians(angle_deg), value, ()
    low, high = method.angles
    outside = (angle_deg < low) | (angle_deg >= high)
    count = int(np.count_nonzero(outside))
    if not count:
        return to_radians(angle_deg), value, ()
    words = f"{count} of {len(outside)} pairs left out: angle outside {low:g}° to {high:g}°."
    return to_radians(angle_deg[~outside]), value[~outside], (words,)


def describe_method(method: Method) -> str:
    """A method in a few words, e.g. ``means per 5° step, 0° to 80°``."""
    words = {
        "points": "single points",
        "bins": f"means per {method.width:g}° step",
        "edge": f"upper edge ({100 * method.tau:g} % below)",
    }[method.to]
    if method.loss != "squares":
        words += f", {method.loss.capitalize()}'s loss"
    if method.angles != ALL_ANGLES:
        words += f", {method.angles[0]:g}° to {method.angles[1]:g}°"
    return words
