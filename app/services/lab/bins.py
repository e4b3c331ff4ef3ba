"""Means per step of the angle as a fit to means sees them, for bars in plots; degrees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.units import to_degrees, to_radians
from app.services.lab.own_models import AnyModel, find_model


@dataclass(frozen=True, slots=True, eq=False)
class AngleBins:
    """Means per step, (b,) arrays.

    Attributes
    ----------
    angle, value : arrays
        Means of the pairs of a step, the angle in degrees.
    sd, error : arrays
        Standard deviation of a value of the step, and standard error of the mean; NaN where
        nothing scatters. See `app.core.fitting.bins.average_bins` for steps of few points.
    count : integers
    """

    angle: Floats
    value: Floats
    sd: Floats
    error: Floats
    count: Ints


def average(
    angle_deg: Floats, value: Floats, width: float = 5.0, model: AnyModel = "lambert"
) -> AngleBins:
    """Means and scatter per step of `width` degrees of the pairs that a model accepts."""
    from app.core.fitting.bins import average_bins

    angle = to_radians(np.asarray(angle_deg, np.float64))
    means = average_bins(find_model(model), angle, value, float(to_radians(width)))
    sd = means.error * np.sqrt(means.count)
    return AngleBins(to_degrees(means.angle), means.value, sd, means.error, means.count)
