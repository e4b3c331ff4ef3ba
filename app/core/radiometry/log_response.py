"""Logarithmic amplifier: FARO, and everything that is stored in decibels."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.radiometry.step import Step, spread

LN10 = float(np.log(10.0))


class LogResponse(Step, frozen=True):
    """y = a1 + a0 · log10 x, so that ρ = 10^((DN − a1) / a0) (Junttila 2016, equation 3).

    Attributes
    ----------
    a0 : float
        DN per decade.
    a1 : float
        DN of a reflectance of 1.
    """

    free: ClassVar[tuple[str, ...]] = ("a0", "a1")
    title: ClassVar[str] = "Logarithmic response"
    source: ClassVar[str] = "Junttila et al. 2016, equation 3"

    a0: float
    a1: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.a1) and 0.0 < self.a0 < np.inf):
            raise WrongUse(f"A logarithmic response needs a positive a0, not {self.a0:g}.")

    def respond(self, x: Floats, distance: Floats) -> Floats:
        positive = np.where(np.asarray(x) > 0.0, x, np.nan)
        return spread(self.a1 + self.a0 / LN10 * np.log(positive), x, distance)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        with np.errstate(over="ignore"):
            x = np.exp((y - self.a1) * (LN10 / self.a0))
        return spread(np.where((x > 0.0) & (x < np.inf), x, np.nan), y, distance)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(self.a0 / LN10 / x, x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        x = spread(x, x, distance)
        return np.stack([np.log(x) / LN10, np.ones(x.shape)])


class Decibel(LogResponse, frozen=True):
    """y = 10 · log10 x: a reflectance in dB, taken as it is (RIEGL)."""

    free: ClassVar[tuple[str, ...]] = ()
    title: ClassVar[str] = "Decibel"
    source: ClassVar[str] = "definition of the decibel"

    a0: float = 10.0
    a1: float = 0.0

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        return np.empty((0, *spread(x, x, distance).shape))
