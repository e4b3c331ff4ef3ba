"""Whether a fit belongs to the points that are shown."""

from __future__ import annotations

import numpy as np

from app.core.fitting import FitResult
from app.core.fitting.bins import average_bins
from app.core.units import to_radians
from app.model.fit_method import Method
from app.services.lab.gather import Measured
from app.services.lab.method import choose_pairs

EQUAL = 1e-6
MOST_CHECKED = 200_000
"""Points up to which the residuals are summed anew; with more their number and angles tell."""


def is_stale(result: FitResult, method: Method, measured: Measured) -> bool:
    """Say whether a fit was made on other points: another number, other angles or values."""
    angle, value, _ = choose_pairs(method, measured.angle, measured.value)
    weight = np.ones(1)
    model = result.angular_model
    if method.to == "bins":
        means = average_bins(model, angle, value, float(to_radians(method.width)))
        angle, value = means.angle, means.value
        weight = weight if means.weights is None else means.weights
    else:
        inside = model.accepts(angle)
        angle, value = angle[inside], value[inside]
    if len(angle) != result.n:
        return True
    ends = (float(angle.min()), float(angle.max()))
    if not np.allclose(ends, result.angle_range, rtol=EQUAL, atol=EQUAL):
        return True
    if not method.by_squares or len(angle) > MOST_CHECKED:
        return False
    rss = float((weight * (value - result.evaluate(angle)) ** 2).sum())
    least = EQUAL * float((weight * value**2).sum())  # a perfect fit leaves only rounding
    return abs(rss - result.rss) > max(EQUAL * result.rss, EQUAL * least)
