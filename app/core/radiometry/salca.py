"""SALCA's response: steep below the knee, nearly level above it."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.radiometry.step import Step, spread

BRIGHTEST = 1e3
"""Largest effective reflectance that is looked for; real ones stay below 20."""


class SalcaResponse(Step, frozen=True):
    """y = (m·x + c) · (1 − e^(−k·x)) (Hancock 2017, equation A3).

    It rises everywhere, so that its inverse is one root between bounds.

    Attributes
    ----------
    m, c, k : float
        Positive; y in DN, x the effective reflectance.
    """

    free: ClassVar[tuple[str, ...]] = ("m", "c", "k")
    title: ClassVar[str] = "SALCA's response"
    source: ClassVar[str] = "Hancock et al. 2017, equation A3"

    m: float
    c: float
    k: float

    def __post_init__(self) -> None:
        if not all(0.0 < value < np.inf for value in (self.m, self.c, self.k)):
            raise WrongUse(
                f"SALCA's response needs positive m, c and k, not {self.m:g}, {self.c:g} and "
                f"{self.k:g}."
            )

    def respond(self, x: Floats, distance: Floats) -> Floats:
        positive = np.where((np.asarray(x) >= 0.0) & (np.asarray(x) <= BRIGHTEST), x, np.nan)
        y = -(self.m * positive + self.c) * np.expm1(-self.k * positive)
        return spread(y, x, distance)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        from app.core.kernels.salca import invert_salca

        flat = np.ascontiguousarray(np.ravel(y), np.float64)
        x = invert_salca(flat, self.m, self.c, self.k, BRIGHTEST).reshape(np.shape(y))
        return spread(x, y, distance)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        fall = np.exp(-self.k * x)
        slope = -self.m * np.expm1(-self.k * x) + (self.m * x + self.c) * self.k * fall
        return spread(slope, x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        x = spread(x, x, distance)
        rise = -np.expm1(-self.k * x)
        return np.stack([x * rise, rise, (self.m * x + self.c) * x * np.exp(-self.k * x)])
