"""Standard deviations from the Jacobian at the solution: covariance = s²·(JᵀWJ)⁻¹."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats

# Below this share of the largest singular value a direction is not determined by the data.
SINGULAR = 1e-10
TAKES_PART = 1e-6


def compute_deviations(jacobian: Floats, noise: float) -> Floats:
    """Standard deviation of each parameter.

    Parameters
    ----------
    jacobian : (n, p) array
        Rows multiplied by the root of their weight.
    noise : float
        s, standard deviation of a value of weight 1.

    Returns
    -------
    (p,) array
        NaN for a parameter that the data do not determine.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    seen = lengths > 0
    result = np.full(jacobian.shape[1], np.nan)
    if not seen.any():
        return result
    _, singular, turned = np.linalg.svd(jacobian[:, seen] / lengths[seen], full_matrices=False)
    lost = singular <= SINGULAR * singular[0]
    shares = turned[~lost] / singular[~lost, None]
    sd = noise * np.sqrt((shares**2).sum(axis=0)) / lengths[seen]
    vague = (np.abs(turned[lost]) > TAKES_PART).any(axis=0)
    result[seen] = np.where(vague, np.nan, sd)
    return result
