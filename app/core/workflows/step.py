"""What a step of a correction gives: values, and how they depend on everything they came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.core.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Stepped:
    """Values after a step, with their first derivatives; all arrays are (n,).

    Attributes
    ----------
    value : array
    by_value : array
        Derivative by the value before the first step.
    by_angle : array
        Derivative by the incidence angle, per radian.
    by_parameter : mapping of str to array
    """

    value: Floats
    by_value: Floats
    by_angle: Floats
    by_parameter: Mapping[str, Floats] = field(default_factory=dict)

    def then(self, later: Stepped) -> Stepped:
        """Join this step with one that took its values (chain rule)."""
        names = dict.fromkeys([*self.by_parameter, *later.by_parameter])
        nothing = np.zeros(np.shape(self.value))
        return Stepped(
            later.value,
            later.by_value * self.by_value,
            later.by_value * self.by_angle + later.by_angle,
            {
                name: later.by_value * self.by_parameter.get(name, nothing)
                + later.by_parameter.get(name, nothing)
                for name in names
            },
        )


def begin(value: Floats) -> Stepped:
    """Values before any step."""
    value = np.asarray(value, dtype=np.float64)
    return Stepped(value, np.ones(value.shape), np.zeros(value.shape))
