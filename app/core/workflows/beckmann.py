"""The Beckmann term of glossy leaves, and how it depends on angle and roughness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Gloss:
    """e^(−tan²ω/m²)/cos⁵ω and its logarithmic derivatives, (n,) arrays.

    Attributes
    ----------
    term : array
    log_by_angle : array
        d ln(term)/dω.
    log_by_m : array
    """

    term: Floats
    log_by_angle: Floats
    log_by_m: Floats


def compute_gloss(angle: Floats, values: Mapping[str, float]) -> Gloss:
    """The term for a roughness m; without an m (k_d is 1) there is no gloss at all.

    Parameters
    ----------
    angle : (n,) array
        Radians.
    values : mapping
        May hold m.
    """
    m = values.get("m", np.nan)
    if np.isnan(m):
        nothing = np.zeros(np.shape(angle))
        return Gloss(nothing, nothing, nothing)
    slope = np.tan(angle)
    t = slope**2
    # This form neither overflows nor divides by zero at 90°.
    term = np.exp(2.5 * np.log1p(t) - t / m**2)
    return Gloss(term, 2.0 * slope * (2.5 - (1.0 + t) / m**2), 2.0 * t / m**3)
