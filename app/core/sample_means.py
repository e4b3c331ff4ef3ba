"""Means of samples: what two scanners that never met the same point can be compared by.

Two instruments that scan one sample from different places, with different steps, share no
points: their index is that of the sample's means (Junttila 2016, "index of the means"). One
instrument with both channels also has an index at every point and its mean (Hancock 2017, "mean
of the index"). The two differ, and are named so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints, finite_rows
from app.core.errors import WrongUse
from app.core.indices import NamedIndex, evaluate


@dataclass(frozen=True, slots=True)
class Mean:
    """Mean of a sample in one channel, or of an index over its points.

    Attributes
    ----------
    mean, sd : float
        NaN without values; the sd (n - 1) also with one.
    count : int
        Finite values.
    """

    mean: float
    sd: float
    count: int

    @property
    def standard_error(self) -> float:
        """Of the mean, as if points were independent: sd / √n.

        Neighbouring beams that overlap, or whose noise was filtered, are not: then it is too
        small. It says nothing of calibration.
        """
        return self.sd / float(np.sqrt(self.count)) if self.count else float("nan")


@dataclass(frozen=True, slots=True)
class IndexOfMeans:
    """Index of the means of two channels, and its standard error; NaN where it does not exist."""

    value: float
    standard_error: float


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Points of two scans that are each other's nearest.

    Attributes
    ----------
    first, second : (p,) int64
        Rows in the two scans.
    distance : (p,) metres
    shares : (float, float)
        Of the first and of the second scan's points with coordinates: how many found a partner.
    """

    first: Ints
    second: Ints
    distance: Floats
    shares: tuple[float, float]


def mean_of(values: Floats) -> Mean:
    """Mean, standard deviation and count of the finite values of an array."""
    known = np.asarray(values, dtype=np.float64)
    known = known[np.isfinite(known)]
    if len(known) == 0:
        return Mean(float("nan"), float("nan"), 0)
    sd = float(known.std(ddof=1)) if len(known) > 1 else float("nan")
    return Mean(float(known.mean()), sd, len(known))


def index_of_means(
    index: NamedIndex, first: Mean, second: Mean, covariance: float = 0.0
) -> IndexOfMeans:
    """Index of the means of a sample (Junttila 2016), its error by propagation.

    Parameters
    ----------
    index : NamedIndex
    first, second : Mean
        In the order of the index's roles.
    covariance : float
        Of the two means: 0 for two instruments; see `covariance_of_means` for one.

    Returns
    -------
    IndexOfMeans
        To first order, σ² = (∂/∂a)² s_a² + (∂/∂b)² s_b² + 2 (∂/∂a)(∂/∂b) cov.
    """
    a, b = first.mean, second.mean
    value = float(evaluate(index, dict(zip(index.roles, map(np.array, (a, b)), strict=True))))
    if not np.isfinite(value):
        return IndexOfMeans(float("nan"), float("nan"))
    bottom = (a + b) ** 2 if index.normalised else b**2
    by_first, by_second = (2.0 * b, -2.0 * a) if index.normalised else (b, -a)
    variance = (by_first * first.standard_error) ** 2 + (by_second * second.standard_error) ** 2
    variance += 2.0 * by_first * by_second * covariance
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        error = np.sqrt(np.maximum(variance, 0.0)) / np.float64(bottom)
    return IndexOfMeans(value, float(error) if np.isfinite(error) else float("nan"))


def covariance_of_means(first: Floats, second: Floats) -> float:
    """Covariance of the means of two channels of the same points; 0 below two common points."""
    both = np.isfinite(first) & np.isfinite(second)
    count = int(both.sum())
    if count < 2:
        return 0.0
    # Points with one channel only add to one mean and to nothing in common.
    share = count / float(np.isfinite(first).sum()) / float(np.isfinite(second).sum())
    return float(np.cov(first[both], second[both])[0, 1]) * share


def mean_of_index(index: NamedIndex, values: Mapping[str, Floats]) -> Mean:
    """Mean of the index of every point (Hancock 2017); points without one are left out."""
    return mean_of(evaluate(index, values))


def pair_nearest(first: Floats, second: Floats, within: float) -> Pairs:
    """Pair the points of two scans that are each other's nearest, within a tolerance.

    By distance between points: beams of scanners that stand apart cross at one place only, so
    their directions say nothing. Mutual, so that no point is used twice where one scan is denser.

    Parameters
    ----------
    first, second : (n, 3), (m, 3) metres
        In one system of coordinates. Rows that are not finite are left out.
    within : float
        Metres.

    Raises
    ------
    WrongUse
        The tolerance is not a positive length.
    """
    from scipy.spatial import cKDTree

    if not (np.isfinite(within) and within > 0.0):
        raise WrongUse(f"Points are paired within a positive distance, not within {within:g} m.")
    rows = [np.flatnonzero(finite_rows(xyz)) for xyz in (first, second)]
    if not len(rows[0]) or not len(rows[1]):
        none = np.empty(0, np.int64)
        return Pairs(none, none, np.empty(0), (0.0, 0.0))
    known = first[rows[0]], second[rows[1]]
    found = cKDTree(known[1]).query(known[0], distance_upper_bound=within)
    distance, there = np.asarray(found[0]), np.asarray(found[1])
    back = np.asarray(cKDTree(known[0]).query(known[1], distance_upper_bound=within)[1])
    back = np.append(back, -1)  # where a point has no neighbour, the tree answers one too many
    mutual = np.flatnonzero(back[there] == np.arange(len(rows[0])))
    pairs = rows[0][mutual], rows[1][there[mutual]]
    shares = (len(mutual) / len(rows[0]), len(mutual) / len(rows[1]))
    return Pairs(*pairs, distance[mutual], shares)
