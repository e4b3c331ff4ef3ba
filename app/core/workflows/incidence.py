"""Step: divide by what the angle of incidence takes away (Junttila 2016, equation 6)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.core.arrays import Floats
from app.core.workflows.step import Stepped


def divide_incidence(value: Floats, angle: Floats, values: Mapping[str, float]) -> Stepped:
    """I / (1 − b·(1 − cos ω)).

    Parameters
    ----------
    value : (n,) array
    angle : (n,) array
        Radians.
    values : mapping
        Holds b.
    """
    b, lost = values["b"], 1.0 - np.cos(angle)
    factor = 1.0 / compute_bracket(angle, b)
    return Stepped(
        value * factor,
        factor,
        value * b * np.sin(angle) * factor**2,
        {"b": value * lost * factor**2},
    )


def compute_bracket(angle: Floats, b: float) -> Floats:
    """1 − b·(1 − cos ω), (n,); the correction explodes where it nears 0."""
    bracket: Floats = 1.0 - b * (1.0 - np.cos(angle))
    return bracket
