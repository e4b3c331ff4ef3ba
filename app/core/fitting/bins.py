"""Means per bin of angle, weighted by how well each is known, and fits to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.fitting.pairs import choose_pairs
from app.core.fitting.result import FitResult
from app.core.fitting.single import AnyModel, fit
from app.core.phase import get_model
from app.core.units import to_degrees, to_radians

WIDTH = float(to_radians(5.0))
# Points of the pooled scatter that are added to those of each bin.
PRIOR = 4.0
RULE = (
    "Weights are 1/SE² of the bins' means; the variance of a bin is that of its points and, with"
    " the weight of 4 points, that of all bins."
)


@dataclass(frozen=True, slots=True, eq=False)
class BinMeans:
    """Means of the pairs in bins of equal width that begin at multiples of it.

    Attributes
    ----------
    angle, value : (b,) arrays
        Means of the pairs of a bin; the angle in radians.
    error : (b,) array
        Standard error of the mean value; NaN where no bin has two pairs or nothing scatters.
    count : (b,) array
        Pairs of each bin, at least 1.
    warnings : tuple of str
    """

    angle: Floats
    value: Floats
    error: Floats
    count: Ints
    warnings: tuple[str, ...]

    @property
    def weights(self) -> Floats | None:
        """1/SE² of each mean; None where no scatter tells one, and all weigh alike."""
        return self.error**-2.0 if np.isfinite(self.error).all() else None


def average_bins(
    model: AnyModel | str, angle: Floats, value: Floats, width: float = WIDTH
) -> BinMeans:
    """Means and standard errors per bin of the pairs that `model` accepts.

    The variance of a bin of n points is (4·s² + (n − 1)·s_b²)/(n + 3), with s_b² its own and s²
    that within all bins: a bin of two equal points is not thought perfect, and a bin of one
    point gets the scatter of the others. The standard error is its root over √n.

    Parameters
    ----------
    model : PhaseModel, FormulaModel or str
    angle, value : (n,) arrays
        Radians, values.
    width : float
        Radians.

    Raises
    ------
    WrongUse
        The width is not positive.
    BadInput
        Lengths differ.
    """
    if not 0.0 < width < np.inf:
        raise WrongUse(f"Bins need a positive width, not {width:g}.")
    model = get_model(model) if isinstance(model, str) else model
    pairs = choose_pairs(model, angle, value, None)
    # A set angle of 15° may come as 14.999999999999998.
    number = np.floor(pairs.angle / width + 1e-9).astype(np.int64)
    _, place, count = np.unique(number, return_inverse=True, return_counts=True)
    mean = np.bincount(place, pairs.value) / count
    within = np.bincount(place, (pairs.value - mean[place]) ** 2, len(count))
    spare = int((count - 1).sum())
    pooled = float(within.sum()) / spare if spare else 0.0
    variance = (PRIOR * pooled + within) / (PRIOR + count - 1)
    error = np.sqrt(variance / count) if pooled > 0 else np.full(len(count), np.nan)
    single = int((count == 1).sum())
    words = (
        *pairs.warnings,
        *([f"{single} of {len(count)} bins hold one pair and take their scatter from the others."]
          if single and pooled > 0 else []),
        *(["No bin has a scatter: all bins weigh alike."] if len(count) and pooled == 0 else []),
    )  # fmt: skip
    angles = np.bincount(place, pairs.angle) / count
    return BinMeans(angles, mean * pairs.scale, error * pairs.scale, count, words)


def fit_bins(
    model: AnyModel | str,
    angle: Floats,
    value: Floats,
    *,
    width: float = WIDTH,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit the means per bin of angle, weighted by 1/SE²; see `average_bins` for the rule.

    Parameters
    ----------
    model, angle, value, fixed
        See `fit`.
    width : float
        Radians.

    Raises
    ------
    WrongUse, BadInput
        As from `fit`, for the bins: a leaf with one bin is refused.
    """
    means = average_bins(model, angle, value, width)
    result = fit(model, means.angle, means.value, weights=means.weights, fixed=fixed)
    return tell_bins(result, means, width)


def tell_bins(result: FitResult, means: BinMeans, width: float) -> FitResult:
    """A fit to these means as `fit_bins` gives it: what it was fitted to, and by which rule."""
    words = f"Fitted to {len(means.count)} means of {to_degrees(width):g}° bins."
    rule = () if means.weights is None else (RULE,)
    return replace(result, kind="bins", warnings=(*means.warnings, words, *rule, *result.warnings))
