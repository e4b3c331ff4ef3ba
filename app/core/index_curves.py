"""An index against the angle: from curves fitted to its channels, and from means per step.

Kaasalainen et al. 2018 fit each channel and take the index of the fits; table 5 is its least and
largest value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.channel_index import ChannelIndex
from app.core.errors import BadInput
from app.core.fitting import FitResult, fit

STEP = float(np.deg2rad(5.0))
FINE = float(np.deg2rad(0.5))


@dataclass(frozen=True, slots=True, eq=False)
class FittedChannel:
    """A curve through one channel.

    Attributes
    ----------
    result : FitResult
    names : tuple of str
        Parameters that have a standard deviation.
    covariance : (k, k) array
        Of these.
    """

    result: FitResult
    names: tuple[str, ...]
    covariance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class IndexCurve:
    """An index over the angle, (n,) arrays.

    Attributes
    ----------
    angle : array
        Radians.
    value, sigma : arrays
    count : integers
        Points behind each value; 0 for those of fitted curves.
    """

    angle: Floats
    value: Floats
    sigma: Floats
    count: Ints

    @property
    def extremes(self) -> tuple[float, float, float, float]:
        """Least value and its angle, largest value and its angle; NaN without any value."""
        known = np.flatnonzero(np.isfinite(self.value))
        if not len(known):
            return (float("nan"),) * 4
        low, high = known[np.argmin(self.value[known])], known[np.argmax(self.value[known])]
        found = self.value[low], self.angle[low], self.value[high], self.angle[high]
        return tuple(map(float, found))  # type: ignore[return-value]


def fit_channel(model: str, angle: Floats, value: Floats) -> FittedChannel:
    """Fit a curve to a channel, with the covariance of its parameters.

    Parameters
    ----------
    model : str
    angle : (n,) array
        Radians.
    value : (n,) array

    Raises
    ------
    BadInput
        Too few points or angles, or none of the parameters is determined.
    """
    result = fit(model, angle, value)
    names = tuple(result.covariance)
    if not names:
        raise BadInput(
            f"The angles do not determine a {result.angular_model.title} curve.",
            "Choose a simpler one.",
        )
    table = np.array([[result.covariance[a][b] for b in names] for a in names])
    return FittedChannel(result, names, table)


def curve_of_index(
    index: ChannelIndex, fits: Mapping[str, FittedChannel], angle: Floats | None = None
) -> IndexCurve:
    """The index of fitted channels, with σ from the covariance of their parameters.

    Channels were fitted apart, so their errors count as independent.

    Parameters
    ----------
    index : ChannelIndex
    fits : mapping of channel to FittedChannel
    angle : (n,) array or None
        Radians; None: every half degree where all channels were fitted.
    """
    if angle is None:
        ranges = [fits[channel].result.angle_range for channel in index.channels]
        low, high = max(r[0] for r in ranges), min(r[1] for r in ranges)
        angle = np.linspace(low, high, max(int(np.ceil((high - low) / FINE)), 1) + 1)
    values = {channel: fits[channel].result.evaluate(angle) for channel in index.channels}
    covariance = np.zeros((len(values), len(values), len(angle)))
    for number, channel in enumerate(index.channels):
        found = fits[channel]
        model = found.result.angular_model
        jacobian = model.jacobian(angle, found.result.values, found.names)
        covariance[number, number] = np.einsum("ni,ij,nj->n", jacobian, found.covariance, jacobian)
    sigma = index.propagate(values, covariance)
    return IndexCurve(angle, index.evaluate(values), sigma, np.zeros(len(angle), np.int64))


def bins_of_index(
    index: ChannelIndex, angle: Floats, values: Mapping[str, Floats], step: float = STEP
) -> IndexCurve:
    """The index of the channels' means per step of the angle, with its standard error.

    Parameters
    ----------
    index : ChannelIndex
    angle : (n,) array
        Radians.
    values : mapping of channel to (n,) array
        Points that lack the angle or a channel are left out.
    step : float
        Radians.

    Returns
    -------
    IndexCurve
        At the mean angle of each step; σ is NaN where a step has one point.
    """
    table = np.array([values[channel] for channel in index.channels])
    used = np.isfinite(table).all(axis=0) & np.isfinite(angle)
    # Angles that are steps themselves lie in the middle of theirs.
    place = np.floor(angle[used] / step + 0.5).astype(np.int64)
    steps, whose, count = np.unique(place, return_inverse=True, return_counts=True)
    size = len(steps)
    means = np.array([np.bincount(whose, row, size) / count for row in table[:, used]])
    means = means.reshape(len(table), size)
    rest = table[:, used] - means[:, whose]
    spread = np.full((len(table), len(table), size), np.nan)
    several = count > 1
    for a, first in enumerate(rest):
        for b, second in enumerate(rest):
            total = np.bincount(whose, first * second, size)
            spread[a, b, several] = (total / (count * np.maximum(count - 1, 1)))[several]
    by_channel = dict(zip(index.channels, means, strict=True))
    where = np.bincount(whose, angle[used], size) / count
    sigma = index.propagate(by_channel, spread)
    return IndexCurve(where, index.evaluate(by_channel), sigma, count)
