"""Where a curve starts that was not fitted: usual values, as high as the points are."""

from __future__ import annotations

import numpy as np

from app.core.errors import LeafscopeError
from app.core.fitting import fit
from app.core.phase.angular import AngularModel
from app.core.phase.model import PhaseModel
from app.core.units import to_radians
from widgets.common.angular_points import AngularPoints


def start_curve(model: AngularModel, points: AngularPoints) -> dict[str, float]:
    """Usual values; those that scale with the intensity are solved for the means per step.

    Parameters
    ----------
    model : AngularModel
    points : AngularPoints
        Without any, values of size 1 are taken.
    """
    size = max(abs(points.top), abs(points.bottom), 1e-12)
    usual = model.start_values(size)
    if not len(points.means.angle):
        return usual
    found = _solve(model, points, usual) or _stretch(model, points, usual)
    return found if all(map(np.isfinite, found.values())) else usual


def _solve(
    model: AngularModel, points: AngularPoints, usual: dict[str, float]
) -> dict[str, float] | None:
    """One linear solve; None where the steps are too few for it, or the model is a formula."""
    held = {p.name: usual[p.name] for p in model.parameters if not p.scales}
    if not isinstance(model, PhaseModel):
        return None
    means = points.means
    try:
        result = fit(
            model, to_radians(means.angle), means.value,
            weights=means.count.astype(np.float64), fixed=held,
        )  # fmt: skip
    except LeafscopeError:
        return None
    return dict(result.values)


def _stretch(
    model: AngularModel, points: AngularPoints, usual: dict[str, float]
) -> dict[str, float]:
    """All that scales by one factor, which suffices where there is but one such parameter."""
    means, weights = points.means, points.means.count
    with np.errstate(all="ignore"):
        curve = model.evaluate(to_radians(means.angle), usual)
        factor = float(np.sum(weights * curve * means.value) / np.sum(weights * curve**2))
    if not np.isfinite(factor) or factor <= 0.0:
        return usual
    found = {p.name: usual[p.name] * (factor if p.scales else 1.0) for p in model.parameters}
    return {p.name: min(max(found[p.name], p.lower), p.upper) for p in model.parameters}
