"""Power of the laser during one scan, as a share of that of a reference scan."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.radiometry.step import Step, spread


class Power(Step, frozen=True):
    """y = x · value (P0 of Hancock 2017, A4; drift of Junttila 2016, 2.5).

    Attributes
    ----------
    value : float
        1 for the reference scan.
    """

    free: ClassVar[tuple[str, ...]] = ("value",)
    title: ClassVar[str] = "Laser power of the scan"
    source: ClassVar[str] = "Hancock et al. 2017, equation A4; Junttila et al. 2016, 2.5"

    value: float = 1.0

    def __post_init__(self) -> None:
        check_power(self.value)

    def respond(self, x: Floats, distance: Floats) -> Floats:
        return spread(self.value * x, x, distance)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        return spread(y / self.value, y, distance)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(np.array(self.value), x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        return spread(x, x, distance)[None]


def check_power(value: float) -> None:
    """Refuse (`WrongUse`) a laser power that is not a positive number."""
    if not 0.0 < value < np.inf:
        raise WrongUse(
            f"The laser power of a scan must be a positive share, not {value:g}.",
            "1 is the power of the scan that the profile was made with.",
        )
