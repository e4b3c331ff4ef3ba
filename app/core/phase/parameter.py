"""One parameter of an angular model: its name, unit, bounds and usual range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

AT_BOUND = 1e-9


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a model, as results and sliders show it.

    Attributes
    ----------
    name, unit, meaning : str
        `unit` is ``1`` for a pure number and ``value`` for the unit of the data.
    typical : (float, float)
        Usual range, for sliders and tests; in units of the largest value if `scales`.
    lower, upper : float
        Bounds of a fit.
    scales : bool
        Proportional to the data: I → c·I makes it c times as large.
    wraps : bool
        One bound continues at the other: to lie on it means nothing.
    """

    name: str
    unit: str
    meaning: str
    typical: tuple[float, float]
    lower: float = -np.inf
    upper: float = np.inf
    scales: bool = False
    wraps: bool = False

    @property
    def start(self) -> float:
        """Where a search that needs a start value begins: the middle of the usual range."""
        return sum(self.typical) / 2

    def touches_bound(self, value: Any) -> Any:
        """Whether `value` lies on a bound; for one that scales, in units of the data's size.

        A number gives a bool, an array booleans.
        """
        away = np.minimum(np.abs(value - self.lower), np.abs(value - self.upper))
        return (away <= AT_BOUND) & (not self.wraps)
