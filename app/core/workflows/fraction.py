"""Step: keep the diffuse share of what a glossy leaf sends back (Junttila 2016, section 2.7)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.core.arrays import Floats
from app.core.workflows.beckmann import compute_gloss
from app.core.workflows.step import Stepped


def keep_diffuse(value: Floats, angle: Floats, values: Mapping[str, float]) -> Stepped:
    """I·k_d·cos ω / (k_d·cos ω + (1 − k_d)·e^(−tan²ω/m²)/cos⁵ω).

    Parameters
    ----------
    value : (n,) array
    angle : (n,) array
        Radians.
    values : mapping
        Holds k_d, and m where k_d is below 1.
    """
    k_d, flat, gloss = values["k_d"], np.cos(angle), compute_gloss(angle, values)
    whole = k_d * flat + (1.0 - k_d) * gloss.term
    share = k_d * flat / whole
    # By the logarithm of the ratio of both parts: share·(1 − share) of it arrives.
    turn = share * (1.0 - share)
    by_angle = turn * (-np.tan(angle) - gloss.log_by_angle)
    return Stepped(
        value * share,
        share,
        value * by_angle,
        {"k_d": value * flat * gloss.term / whole**2, "m": -value * turn * gloss.log_by_m},
    )
