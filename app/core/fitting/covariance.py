"""Covariance of parameters from the Jacobian at the solution: s²·(JᵀWJ)⁻¹."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.fitting.projection import combine_rows
from app.core.phase import PhaseModel

# Below this share of the largest singular value a direction is not determined by the data.
SINGULAR = 1e-10
TAKES_PART = 1e-6


def compute_covariance(jacobian: Floats, noise: Any) -> Floats:
    """Covariance matrices of parameters.

    Parameters
    ----------
    jacobian : (..., n, p) array
        Rows multiplied by the root of their weight. A column of zeros, or with a NaN, takes no
        part.
    noise : float or (...) array
        s, standard deviation of a value of weight 1.

    Returns
    -------
    (..., p, p) array
        NaN in the rows and columns of parameters that the data do not determine.
    """
    lengths = np.sqrt(np.einsum("...np,...np->...p", jacobian, jacobian))
    seen = lengths > 0
    safe = np.where(seen, lengths, 1.0)
    # The triangle holds all that the many rows say about the few parameters.
    clean = np.where(seen[..., None, :], jacobian, 0.0)
    triangle = np.linalg.qr(clean / safe[..., None, :], mode="r")
    _, singular, turned = np.linalg.svd(triangle, full_matrices=True)
    singular = _fill(singular, turned.shape[-1])
    lost = singular <= SINGULAR * singular[..., :1]
    shares = np.where(lost, 0.0, 1.0 / np.where(lost, 1.0, singular))[..., None] * turned
    covariance = np.einsum("...ki,...kj->...ij", shares, shares)
    covariance *= np.asarray(noise)[..., None, None] ** 2 / (safe[..., None] * safe[..., None, :])
    # Columns of zeros make directions of their own, which concern nobody else.
    vague = (lost[..., None] & (np.abs(turned) > TAKES_PART)).any(axis=-2) | ~seen
    covariance[vague[..., :, None] | vague[..., None, :]] = np.nan
    return np.asarray(covariance)


def _fill(singular: Floats, count: int) -> Floats:
    missing = count - singular.shape[-1]
    return np.concatenate((singular, np.zeros((*singular.shape[:-1], missing))), axis=-1)


def take_deviations(covariance: Floats) -> Floats:
    """Standard deviations, (..., p), of covariances, (..., p, p)."""
    return np.asarray(np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)))


def stack_jacobians(
    model: PhaseModel, angle: Floats, values: Mapping[str, Any], names: Sequence[str]
) -> Floats:
    """dI/dparameter of groups side by side, (g, n, p).

    Parameters
    ----------
    model : PhaseModel
    angle : (g or 1, n) array
    values : mapping of str to (g,) array
        Finite; an undetermined one may have any value, as its column has no weight.
    names : sequence of str
        The p parameters.
    """
    shape = np.asarray(values.get(model.shape, np.nan))[..., None]
    columns = model.basis(angle, shape)
    slopes = model.coefficient_slopes(values)
    order = {p.name: i for i, p in enumerate(model.linear_parameters)}
    parts = [
        combine_rows(model.coefficients(values), model.basis_by_shape(angle, shape))
        if name == model.shape
        else combine_rows(slopes[..., :, order[name]], columns)
        for name in names
    ]
    groups = max(len(part) if part.ndim > 1 else 1 for part in parts)
    wide = [np.broadcast_to(part, (groups, angle.shape[-1])) for part in parts]
    return np.stack(wide, axis=-1)
