"""Step: subtract the specular part that a sample's own fit foretells, the named alternative."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.core.arrays import Floats
from app.core.workflows.beckmann import compute_gloss
from app.core.workflows.step import Stepped


def subtract_specular(value: Floats, angle: Floats, values: Mapping[str, float]) -> Stepped:
    """I − f·(1 − k_d)·e^(−tan²ω/m²)/cos⁵ω; may fall below zero.

    Parameters
    ----------
    value : (n,) array
    angle : (n,) array
        Radians.
    values : mapping
        Holds f in the unit of `value`, k_d, and m where k_d is below 1.
    """
    f, k_d, gloss = values["f"], values["k_d"], compute_gloss(angle, values)
    specular = f * (1.0 - k_d) * gloss.term
    return Stepped(
        value - specular,
        np.ones(np.shape(value)),
        -specular * gloss.log_by_angle,
        {
            "f": -(1.0 - k_d) * gloss.term,
            "k_d": f * gloss.term,
            "m": -specular * gloss.log_by_m,
        },
    )
