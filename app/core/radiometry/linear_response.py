"""Linear amplifier: with an offset (Leica), or in proportion to a panel (HSL)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.radiometry.step import Step, spread


class LinearResponse(Step, frozen=True):
    """ρ = a · DN + b (Junttila 2016, 2.5), so that y = (x − b) / a.

    Attributes
    ----------
    a : float
        Reflectance per DN.
    b : float
        Reflectance at 0 DN.
    """

    free: ClassVar[tuple[str, ...]] = ("a", "b")
    title: ClassVar[str] = "Linear response"
    source: ClassVar[str] = "Junttila et al. 2016, 2.5"

    a: float
    b: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.b) and 0.0 < self.a < np.inf):
            raise WrongUse(f"A linear response needs a positive a, not {self.a:g}.")

    def respond(self, x: Floats, distance: Floats) -> Floats:
        return spread((x - self.b) / self.a, x, distance)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        return spread(self.a * y + self.b, y, distance)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(np.array(1.0 / self.a), x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        x = spread(x, x, distance)
        return np.stack([(self.b - x) / self.a**2, np.full(x.shape, -1.0 / self.a)])


class Proportional(Step, frozen=True):
    """y = gain · x: each channel divided by a panel at the same range (Kaasalainen 2018, 2.2).

    Attributes
    ----------
    gain : float
        Number of a reflectance of 1.
    """

    free: ClassVar[tuple[str, ...]] = ("gain",)
    title: ClassVar[str] = "Proportional response"
    source: ClassVar[str] = "Kaasalainen et al. 2018, 2.2"

    gain: float

    def __post_init__(self) -> None:
        if not 0.0 < self.gain < np.inf:
            raise WrongUse(f"A proportional response needs a positive gain, not {self.gain:g}.")

    def respond(self, x: Floats, distance: Floats) -> Floats:
        return spread(self.gain * x, x, distance)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        return spread(y / self.gain, y, distance)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(np.array(self.gain), x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        return spread(x, x, distance)[None]
