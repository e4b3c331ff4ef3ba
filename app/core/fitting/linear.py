"""Linear least squares for one set of columns or a stack of them, with bounds."""

from __future__ import annotations

import itertools

import numpy as np

from app.core.arrays import Floats

# A column that keeps less of its length than this beside the others tells nothing new.
DEPENDENT = 1e-12


def solve_bounded(
    columns: Floats, target: Floats, lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Least squares within bounds.

    Parameters
    ----------
    columns : (..., k, n) array
    target : (..., n) array
        The stacks of columns and targets broadcast.
    lower, upper : (..., k) arrays
        Bounds; at most two columns may be bounded, and then there are no others.

    Returns
    -------
    coefficients : (..., k) array
    residual : (..., n) array
    """
    best, residual = solve_free(columns, target)
    outside = ((best < lower) | (best > upper)).any(axis=-1)
    if not outside.any():
        return best, residual
    stack, count = best.shape[:-1], best.shape[-1:]
    best[outside], residual[outside] = _solve_on_edges(
        np.broadcast_to(columns, (*stack, *columns.shape[-2:]))[outside],
        np.broadcast_to(target, residual.shape)[outside],
        np.broadcast_to(lower, stack + count)[outside],
        np.broadcast_to(upper, stack + count)[outside],
    )
    return best, residual


def solve_free(columns: Floats, target: Floats) -> tuple[Floats, Floats]:
    """Least squares by modified Gram–Schmidt on [columns | target], which is stable.

    A dependent column gets the coefficient 0. Shapes as in `solve_bounded`.
    """
    count, stack = columns.shape[-2], columns.shape[:-2]
    both = np.broadcast_shapes(stack, target.shape[:-1])
    q = columns.astype(np.float64, copy=True)
    residual = np.array(np.broadcast_to(target, (*both, columns.shape[-1])), dtype=np.float64)
    r = np.zeros((*stack, count, count))
    z = np.zeros((*both, count))
    start = _length(q)
    for j in range(count):
        length = _length(q[..., j, :]) if j else start[..., 0]
        told = length > DEPENDENT * start[..., j]
        scale = np.divide(1.0, length, out=np.zeros_like(length), where=told)
        q[..., j, :] *= scale[..., None]
        r[..., j, j] = np.where(told, length, 1.0)
        for i in range(j + 1, count):
            r[..., j, i] = _dot(q[..., j, :], q[..., i, :])
            q[..., i, :] -= r[..., j, i, None] * q[..., j, :]
        z[..., j] = _dot(q[..., j, :], residual)
        residual -= z[..., j, None] * q[..., j, :]
    return _substitute_back(r, z), residual


def _substitute_back(r: Floats, z: Floats) -> Floats:
    coefficients = np.zeros_like(z)
    for j in reversed(range(z.shape[-1])):
        known = _dot(r[..., j, j + 1 :], coefficients[..., j + 1 :])
        coefficients[..., j] = (z[..., j] - known) / r[..., j, j]
    return coefficients


def _solve_on_edges(
    columns: Floats, target: Floats, lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Best point on the border of the box: one coefficient on a bound, the other free or clipped.

    The sum of squares is convex, so that a free minimum outside puts the bounded one there.
    """
    best = np.zeros(columns.shape[:-1])
    residual = np.array(target)
    least = np.full(columns.shape[:-2], np.inf)
    for j, bound in itertools.product(range(columns.shape[-2]), (lower, upper)):
        if not np.isfinite(bound[..., j]).all():
            continue
        trial = np.zeros_like(best)
        trial[..., j] = bound[..., j]
        rest = target - bound[..., j, None] * columns[..., j, :]
        for i in set(range(columns.shape[-2])) - {j}:
            square = _dot(columns[..., i, :], columns[..., i, :])
            along = _dot(columns[..., i, :], rest)
            ideal = np.divide(along, square, out=np.zeros_like(square), where=square > 0)
            trial[..., i] = np.clip(ideal, lower[..., i], upper[..., i])
            rest = rest - trial[..., i, None] * columns[..., i, :]
        rss = _dot(rest, rest)
        better = rss < least
        best[better], residual[better], least[better] = trial[better], rest[better], rss[better]
    return best, residual


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = np.einsum("...n,...n->...", a, b)
    return product


def _length(a: Floats) -> Floats:
    return np.sqrt(_dot(a, a))
