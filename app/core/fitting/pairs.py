"""The pairs that a fit uses: cleaned, counted, scaled to the size of 1."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.phase.angular import AngularModel

# Squares of larger values overflow.
LARGEST = 1e150


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Angles and values that can be fitted.

    Attributes
    ----------
    angle : (n,) array
        Radians.
    value : (n,) array
        Divided by `scale`, so that intensities of any size are treated alike.
    weight : (n,) array
        Divided by `weight_scale`; all 1 without weights.
    scale, weight_scale : float
    warnings : tuple of str
        What was left out.
    kept : (N,) array of bool
        Which of the given pairs these are.
    """

    angle: Floats
    value: Floats
    weight: Floats
    scale: float
    weight_scale: float
    warnings: tuple[str, ...] = ()
    kept: Bools = field(default_factory=lambda: np.ones(0, np.bool_), repr=False)

    def __len__(self) -> int:
        return len(self.angle)


def choose_pairs(
    model: AngularModel, angle: Floats, value: Floats, weights: Floats | None
) -> Pairs:
    """Leave out what cannot be fitted, and count it.

    Raises
    ------
    BadInput
        Lengths differ, or a weight is negative.
    """
    angle = as_numbers("angle", angle).ravel()
    value = as_numbers("value", value).ravel()
    weight = np.ones(len(angle)) if weights is None else as_numbers("weight", weights).ravel()
    if not len(angle) == len(value) == len(weight):
        raise BadInput(
            f"A fit needs as many values as angles: {len(angle)} angles, {len(value)} values,"
            f" {len(weight)} weights."
        )
    if (weight < 0).any():
        raise BadInput("A weight is negative.", "Weights are 1/σ² or counts.")
    finite = np.isfinite(angle) & (np.abs(value) < LARGEST) & np.isfinite(weight)
    inside = finite & model.accepts(angle)
    keep = inside & (weight > 0)
    warnings = (
        *_count(~finite, len(angle), "no finite number"),
        *_count(finite & ~inside, len(angle), "angle outside the model's 0° to 90°"),
        *_count(inside & ~keep, len(angle), "weight 0"),
    )
    scale = float(np.abs(value[keep]).max(initial=0.0)) or 1.0
    weight_scale = float(weight[keep].max(initial=0.0)) or 1.0
    return Pairs(
        angle[keep],
        value[keep] / scale,
        weight[keep] / weight_scale,
        scale,
        weight_scale,
        warnings,
        keep,
    )


def as_numbers(what: str, numbers: npt.ArrayLike) -> Floats:
    """Real numbers as float64; raises `BadInput` where something is none."""
    array: AnyArray = np.asarray(numbers)
    try:
        return array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise BadInput(f"Not every {what} is a number.") from error


def _count(left_out: Bools, total: int, why: str) -> tuple[str, ...]:
    count = int(left_out.sum())
    return (f"{count} of {total} pairs left out: {why}.",) if count else ()


def condense(pairs: Pairs, bins: int) -> Pairs:
    """Weighted means per bin of angle: the shape of many pairs, for a first search.

    Bins are narrow at small angles, where the peaks of a glossy leaf are.
    """
    if len(pairs) <= bins:
        return pairs
    place = place_in_bins(pairs.angle, bins)
    total = np.bincount(place, pairs.weight, bins).astype(np.float64)
    used = total > 0
    weight = total[used]
    angle = np.bincount(place, pairs.weight * pairs.angle, bins)[used] / weight
    value = np.bincount(place, pairs.weight * pairs.value, bins)[used] / weight
    return Pairs(angle, value, weight, pairs.scale, pairs.weight_scale)


def place_in_bins(angle: Floats, bins: int) -> Ints:
    """Number of the bin of each angle, 0 to `bins` − 1; narrow bins at small angles."""
    low, high = angle.min(), angle.max()
    place = np.sqrt((angle - low) / (high - low)) * bins
    return np.asarray(np.minimum(place.astype(np.int64), bins - 1))
