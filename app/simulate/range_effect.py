"""How the strength of a return changes with range, relative to a reference range."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf
from typing import TypeAlias

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.simulate.limits import check_not_negative, check_positive

LATTICE = 0.002
"""Metres between the samples of a range effect."""
LATTICE_END = 400.0
"""Metres; an effect is sampled no farther."""


@dataclass(frozen=True, slots=True)
class NoEffect:
    """The instrument, or its software, has taken the range out already."""

    def strength(self, distance: Floats, channel: int) -> Floats:
        """f(distance) / f(reference) of a channel, (n,)."""
        return np.ones(np.shape(distance))


@dataclass(frozen=True, slots=True)
class InverseSquare:
    """f(d) = 1 / (d² + near²) (science: Balduzzi, section 1.1, with near = 0).

    Attributes
    ----------
    reference : float
        Range at which the detector's response is stated, metres.
    near : float
        Range below which the optics hold back light, so that f levels off; metres.
    """

    reference: float
    near: float = 0.0

    NEAREST = 0.0
    FARTHEST = inf

    def __post_init__(self) -> None:
        check_positive("The reference range", self.reference)
        check_not_negative("The range where the inverse square levels off", self.near)

    def strength(self, distance: Floats, channel: int) -> Floats:
        """f(distance) / f(reference) of a channel, (n,)."""
        away = np.square(distance) + self.near**2
        return np.asarray((self.reference**2 + self.near**2) / away)


@dataclass(frozen=True, slots=True)
class Hancock:
    """g(r) = r^(−a) · (1 − e^(−k2 · r))^k3, divided by g(reference) (science: Hancock A5).

    Attributes
    ----------
    a, k2, k3 : tuple of float
        One per channel.
    reference : float
        Metres.
    """

    a: tuple[float, ...]
    k2: tuple[float, ...]
    k3: tuple[float, ...]
    reference: float = 8.0

    NEAREST = 2.0
    FARTHEST = 60.0

    def __post_init__(self) -> None:
        if not len(self.a) == len(self.k2) == len(self.k3):
            raise WrongUse(
                "The range effect has a, k2 and k3 for different numbers of channels.",
                "Give one of each per channel.",
            )
        for value in (*self.a, *self.k2, *self.k3):
            check_positive("A parameter of the range effect", value)
        self._refuse_outside(np.array([self.reference]))

    def strength(self, distance: Floats, channel: int) -> Floats:
        """f(distance) / f(reference) of a channel, (n,).

        Raises
        ------
        WrongUse
            A distance is outside the calibrated 2 to 60 m; g grows without bound towards 0.
        """
        away = np.asarray(distance, float)
        self._refuse_outside(away)
        reference = self._evaluate(np.array(self.reference), channel)
        return np.asarray(self._evaluate(away, channel) / reference)

    def _evaluate(self, away: Floats, channel: int) -> Floats:
        a, k2, k3 = self.a[channel], self.k2[channel], self.k3[channel]
        return np.asarray(away**-a * (-np.expm1(-k2 * away)) ** k3)

    def _refuse_outside(self, away: Floats) -> None:
        outside = away[~((away >= self.NEAREST) & (away <= self.FARTHEST))]
        if outside.size:
            raise WrongUse(
                f"The range effect is not known at {outside[0]:g} m.",
                f"It was calibrated from {self.NEAREST:g} to {self.FARTHEST:g} m.",
            )


RangeEffect: TypeAlias = NoEffect | InverseSquare | Hancock


def sample_strength(effect: InverseSquare | Hancock, channels: int, farthest: float) -> Floats:
    """f(d) / f(reference) at d = 0, h, 2h … with h = `LATTICE`, (channels, k).

    Between the samples it is linear to 1e-5 from 0.6 m on. Beyond the ranges for which the
    effect is known it stays as at their ends; at 0 it is what it is at h.

    Parameters
    ----------
    effect : InverseSquare or Hancock
    channels : int
    farthest : float
        Metres; the last sample lies there or just behind, at most at `LATTICE_END`.
    """
    steps = ceil(min(farthest, LATTICE_END) / LATTICE)
    away = LATTICE * np.maximum(np.arange(steps + 1), 1)
    away = np.clip(away, effect.NEAREST, effect.FARTHEST)
    return np.stack([effect.strength(away, k) for k in range(channels)])
