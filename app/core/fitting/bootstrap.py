"""Bootstrap by leaf: what other leaves of the same kind would have given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.fitting.batch import fit_many
from app.core.fitting.pairs import Pairs, choose_pairs, place_in_bins
from app.core.fitting.single import require_enough
from app.core.fitting.solve import check_fixed
from app.core.phase import PhaseModel, choose_model
from app.core.progress import QUIET, Progress

COUNT = 1000
MOST_COUNT = 100_000
FEWEST_LEAVES = 5
BINS = 256


@dataclass(frozen=True, slots=True, eq=False)
class Bootstrap:
    """Parameters of resampled leaves.

    Attributes
    ----------
    names : tuple of str
    values : (count, p) array
        NaN where a parameter is undetermined or a trial cannot be fitted.
    leaves : int
    warnings : tuple of str
    """

    names: tuple[str, ...]
    values: Floats
    leaves: int
    warnings: tuple[str, ...]

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float] | None:
        """Percentile interval of a parameter; None where half of the trials do not tell it."""
        column = self.values[:, self.names.index(name)]
        known = column[np.isfinite(column)]
        if 2 * len(known) < len(column):
            return None
        low, high = np.quantile(known, [(1 - level) / 2, (1 + level) / 2])
        return float(low), float(high)

    def known(self, name: str) -> float:
        """Share of the trials that determine a parameter."""
        return float(np.isfinite(self.values[:, self.names.index(name)]).mean())


def bootstrap_leaves(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    leaf: AnyArray,
    *,
    weights: Floats | None = None,
    fixed: Mapping[str, float] | None = None,
    count: int = COUNT,
    seed: int = 0,
    progress: Progress = QUIET,
) -> Bootstrap:
    """Fit `count` samples of whole leaves, drawn with replacement.

    Points of one leaf are no independent measurements; leaves are. Pairs at the same angle, or
    in one of 256 narrow bins of it where there are more angles, are replaced by their mean: that
    changes the curve by less than 1e-4 of its size and makes a trial as cheap as a table.

    Parameters
    ----------
    model, angle, value, weights, fixed
        See `fit`.
    leaf : (n,) array
        Number or name of the leaf of each pair.
    count : int
    seed : int
        The same seed gives the same trials.
    progress : Progress

    Raises
    ------
    BadInput
        Lengths differ, fewer than two leaves, or as from `fit`.
    WrongUse
        As from `fit`, or an impossible `count`.
    Cancelled
    """
    if not 1 <= count <= MOST_COUNT:
        raise WrongUse(f"A bootstrap takes 1 to {MOST_COUNT} trials, not {count}.")
    model = choose_model(model)
    fixed = check_fixed(model, dict(fixed or {}))
    leaf = np.asarray(leaf).ravel()
    if len(leaf) != np.size(angle):
        raise BadInput(f"A bootstrap needs the leaf of each pair; there are {len(leaf)}.")
    pairs = choose_pairs(model, angle, value, weights)
    require_enough(model, pairs, len(model.parameters) - len(fixed))
    names, number = np.unique(leaf[pairs.kept], return_inverse=True)
    if len(names) < 2:
        raise BadInput("A bootstrap by leaf needs at least two leaves; there is one.")
    total, angles, values = _resample(pairs, number, _draw(len(names), count, seed))
    batch = fit_many(model, angles, values, total, fixed=fixed, progress=progress)
    few = len(names) < FEWEST_LEAVES
    words = (f"Only {len(names)} leaves: the intervals are too narrow.",) if few else ()
    return Bootstrap(batch.names, batch.values, len(names), (*pairs.warnings, *words))


def _resample(pairs: Pairs, leaf: Ints, drawn: Floats) -> tuple[Floats, Floats, Floats]:
    """Weights, mean angles and mean values of each trial's bins, (count, bins)."""
    place, bins = _place(pairs.angle)
    leaves = drawn.shape[1]
    cell = leaf * bins + place
    weight, angle, value = (
        np.bincount(cell, pairs.weight * column, leaves * bins).reshape(leaves, bins)
        for column in (np.ones(len(pairs)), pairs.angle, pairs.value * pairs.scale)
    )
    total = drawn @ weight
    with np.errstate(invalid="ignore"):
        return total, drawn @ angle / total, drawn @ value / total


def _place(angle: Floats) -> tuple[Ints, int]:
    different, place = np.unique(angle, return_inverse=True)
    if len(different) <= BINS:
        return place, len(different)
    return place_in_bins(angle, BINS), BINS


def _draw(leaves: int, count: int, seed: int) -> Floats:
    """How often each leaf is drawn, (count, leaves)."""
    generator = np.random.default_rng(seed)
    share = np.full(leaves, 1.0 / leaves)
    return generator.multinomial(leaves, share, size=count).astype(np.float64)
