"""Fits that a document holds, found by what they belong to or by their numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping

from app.core.fitting import FitResult
from app.model.leaf import FitRecord
from app.model.parameters import Curve
from app.model.state import State
from widgets.common.curve_choice import Target


def find_newest(state: State, target: Target) -> FitRecord | None:
    """The newest fit of a target, by its method if there is one; None when it was never fitted."""
    wanted = (target.scan, target.leaves, target.channel, target.model)
    found = [
        record
        for record in state.fits.values()
        if (record.scan, record.leaves, record.channel, record.model) == wanted
    ]
    same = [record for record in found if record.method_used == target.method]
    best = same or found
    return best[-1] if best else None


def find_source(state: State, scan: str, curve: Curve) -> FitResult | None:
    """The fit that a curve comes from; None for one that was set by hand."""
    for record in reversed(list(state.fits.values())):
        if (record.scan, record.model, record.channel) != (scan, curve.model, curve.channel):
            continue
        result = FitResult.from_dict(record.result)
        if have_same_values(result.values, curve.values):
            return result
    return None


def have_same_values(first: Mapping[str, float], second: Mapping[str, float]) -> bool:
    """Whether two sets of parameters are the same; undetermined ones may be missing."""

    def determined(values: Mapping[str, float]) -> dict[str, float]:
        return {name: value for name, value in values.items() if math.isfinite(value)}

    return determined(first) == determined(second)
