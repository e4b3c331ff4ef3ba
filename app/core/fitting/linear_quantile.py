"""Quantile regression with given columns, exactly: a linear programme."""

from __future__ import annotations

from typing import Literal

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput
from app.core.phase.model import Freedom

# Pairs up to which the programme takes all of them at once if no curve nearby is known.
SMALL = 2000
# Near a curve that is known, so many times count^(2/3) of them take part.
NEAR, ATTEMPTS = 2.0, 3
# Every 10th pair tells nearly where the curve is.
STRIDE = 10
# Solvers and whether they look at the programme before, the fastest first.
WAYS: tuple[tuple[Literal["highs-ds", "highs-ipm"], bool], ...] = (
    ("highs-ds", False),
    ("highs-ipm", True),
    ("highs-ds", True),
    ("highs-ipm", False),
)
NONE = (2, 3)
"""Status of a programme that has no answer: the edge lies beyond all pairs that took part."""


def measure_pinball(residual: Floats, tau: float) -> float:
    """Σ ρ(r): τ·r above the curve, (1 − τ)·|r| below."""
    return float(np.where(residual >= 0, tau * residual, (tau - 1) * residual).sum())


def solve_quantile(
    columns: Floats, target: Floats, freedom: Freedom, tau: float, guess: Floats | None = None
) -> Floats:
    """Unknowns with the least pinball loss, within bounds.

    Parameters
    ----------
    columns : (j, n) array
    target : (n,) array
        In an order in which every 10th pair is a fair sample.
    freedom : Freedom
        Only the bounds, (j,), are looked at.
    tau : float
    guess : (j,) array, optional
        A curve nearby. Of the pairs only those near it enter the programme, the others are
        taken to stay on their side; where one does not, more enter (Portnoy and Koenker, Stat.
        Sci. 12 (1997) 279). The result is exact all the same.

    Returns
    -------
    (j,) array
    """
    count = target.shape[0]
    found = None if guess is None else _solve_near(columns, target, freedom, tau, guess)
    if found is None and count > SMALL:
        guess = solve_quantile(columns[:, ::STRIDE], target[::STRIDE], freedom, tau)
        found = _solve_near(columns, target, freedom, tau, guess)
    if found is None:
        whole = np.ones(count, np.bool_)
        found = _solve_programme(columns, target, freedom, tau, whole, whole)
    return _require(found)


def _require(found: Floats | None) -> Floats:
    if found is None:
        raise BadInput("The quantile cannot be fitted: the linear programme has no answer.")
    return found


def _solve_near(
    columns: Floats, target: Floats, freedom: Freedom, tau: float, guess: Floats
) -> Floats | None:
    """The exact answer from the pairs near the curve `guess`; None if that is too far off."""
    count = len(target)
    near = int(NEAR * count ** (2 / 3))
    for _ in range(ATTEMPTS):
        if near >= count:
            return None
        residual = target - np.einsum("j,jn->n", guess, columns)
        inside = np.zeros(count, np.bool_)
        inside[np.argpartition(np.abs(residual), near)[:near]] = True
        found = _solve_programme(columns, target, freedom, tau, inside, residual > 0)
        # Without an answer the edge lies beyond all the pairs that took part.
        if found is None:
            return None
        after = target - np.einsum("j,jn->n", found, columns)
        # A pair that was left out must lie on the side that it was given.
        if not (((after > 0) != (residual > 0)) & ~inside & (after != 0)).any():
            return found
        guess, near = found, near * 2
    return None


def _solve_programme(
    columns: Floats, target: Floats, freedom: Freedom, tau: float, inside: Bools, above: Bools
) -> Floats | None:
    """Solve the dual: a multiplier a in [τ − 1, τ] for each pair, a row for each unknown.

    max yᵀa + lower·s − upper·t with X a + s − t = 0 and s, t ≥ 0 where there are bounds; the
    unknowns are the prices of the rows.
    """
    share = np.where(above, tau, tau - 1.0)
    settled = -np.einsum("jn,n->j", columns[:, ~inside], share[~inside])
    # Rows of equal size, which the solver's tolerances need.
    size = np.abs(columns).max(axis=1)
    size[size == 0.0] = 1.0
    unit = np.eye(len(size))
    held, capped = np.isfinite(freedom.lower), np.isfinite(freedom.upper)
    parts = (columns[:, inside] / size[:, None], unit[:, held], -unit[:, capped])
    gain = (target[inside], (freedom.lower * size)[held], -(freedom.upper * size)[capped])
    near, bounds = int(inside.sum()), int(held.sum() + capped.sum())
    limits = [(tau - 1.0, tau)] * near + [(0.0, np.inf)] * bounds
    prices = _price(np.concatenate(gain), np.hstack(parts), settled / size, limits)
    if prices is None:
        return None
    return np.asarray(np.clip(prices / size, freedom.lower, freedom.upper))


def _price(
    gain: Floats, rows: Floats, ends: Floats, limits: list[tuple[float, float]]
) -> Floats | None:
    """Prices of the rows of max gain·a with rows @ a = ends within limits.

    The simplex of pairs that lie in clusters now and then ends in doubt, which is no answer; the
    next way is then tried.
    """
    from scipy.optimize import linprog

    for method, presolve in WAYS:
        found = linprog(
            -gain,
            A_eq=rows,
            b_eq=ends,
            bounds=limits,
            method=method,
            options={"presolve": presolve},
        )
        if found.status == 0:
            return -np.asarray(found.eqlin.marginals)
        if found.status in NONE:
            return None
    return None
