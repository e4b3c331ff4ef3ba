"""The upper edge of a cloud of pairs: a quantile of the value at every angle."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.fitting.block import hold_pairs
from app.core.fitting.linear_quantile import measure_pinball, solve_quantile
from app.core.fitting.pairs import Pairs, choose_pairs
from app.core.fitting.projection import Projection
from app.core.fitting.report import report_fit
from app.core.fitting.result import FitResult
from app.core.fitting.single import require_enough
from app.core.fitting.solve import check_fixed, make_freedom, normalise_fixed
from app.core.phase import PhaseModel, choose_model
from app.core.phase.model import Freedom

TAU = 0.95
# Pairs and trial shapes of the first search; dips that are looked at in all pairs.
SAMPLE, SLICES, STRIDE, CANDIDATES = 1000, 50, 4, 3
REFINEMENTS = 40
# Dips of a sample that differ by less may be in another order in all of the pairs.
CLOSE = 1.05
FEWEST_NEAR = 3
"""Pairs near the edge, per parameter, from which its density is told."""


def fit_edge(
    model: PhaseModel | str,
    angle: Floats,
    value: Floats,
    *,
    tau: float = TAU,
    fixed: Mapping[str, float] | None = None,
) -> FitResult:
    """Fit the curve below which a share `tau` of the pairs lies: Junttila's upper edge.

    For each shape the linear part is an exact linear programme; the shape is sought over all of
    its bounds, in a sample of the pairs that is even in angle and value, then in all of them by
    at most 40 steps in each of the best three dips.

    Parameters
    ----------
    model, angle, value, fixed
        See `fit`.
    tau : float
        Between 0 and 1; 0.5 is the median curve.

    Returns
    -------
    FitResult
        `rss` and `rmse` are of all residuals, as for any curve; `tau` tells what was fitted.
        Standard deviations are Powell's, for independent points.

    Raises
    ------
    WrongUse, BadInput
        As from `fit`; a `tau` that is not between 0 and 1.

    Notes
    -----
    Koenker and Bassett, Econometrica 46 (1978) 33; Junttila et al. 2016, section 2.6.
    """
    model = choose_model(model)
    if not 0.0 < tau < 1.0:
        raise WrongUse(f"A quantile lies between 0 and 1, not at {tau:g}.")
    fixed = check_fixed(model, dict(fixed or {}))
    pairs = arrange(choose_pairs(model, angle, value, None))
    require_enough(model, pairs, len(model.parameters) - len(fixed))
    block = hold_pairs(pairs)
    normal = normalise_fixed(model, fixed, block.rows, block.scale)
    values = solve_edge(model, pairs, normal, tau)
    miss = pairs.value - model.evaluate(pairs.angle, values)
    return report_fit(
        model,
        pairs,
        values,
        {name: float(value[0]) for name, value in normal.items()},
        partial(_covary_edge, residual=miss, tau=tau),
        kind="edge",
        tau=tau,
        warnings=(f"The edge with {tau:.0%} of the pairs below it.",),
    )


def solve_edge(
    model: PhaseModel, pairs: Pairs, fixed: Mapping[str, Floats], tau: float
) -> dict[str, float]:
    """Parameters of the normalised values of `arrange`d pairs with the least pinball loss."""
    search = _EdgeSearch(model, pairs, make_freedom(model, fixed, 1), tau)
    shape = float(fixed[model.shape][0]) if model.shape in fixed else np.nan
    if model.shape and model.shape not in fixed:
        shape = search.find_shape()
    free = search.solve(shape)[1]
    freedom = search.freedom
    coefficients = freedom.offset + np.einsum("kj,j->k", freedom.directions, free)
    values = model.name_values(coefficients, shape, {k: float(v[0]) for k, v in fixed.items()})
    return {name: float(value) for name, value in values.items()}


class _EdgeSearch:
    """The pinball loss of one set of pairs as a function of the shape alone."""

    def __init__(self, model: PhaseModel, pairs: Pairs, freedom: Freedom, tau: float) -> None:
        f = freedom
        self.freedom = Freedom(f.offset[0], f.directions[0], f.lower[0], f.upper[0])
        self.tau, self.pairs, self.model = tau, pairs, model
        one = np.ones((1, len(pairs)))
        self.whole = Projection(model, pairs.angle[None], pairs.value[None], one, freedom)
        few = slice(None, None, -(-len(pairs) // SAMPLE))
        some = pairs.angle[None, few], pairs.value[None, few], one[:, few]
        self.sample = Projection(model, *some, freedom)
        self.guess: dict[bool, Floats] = {}

    def solve(self, shape: float, sample: bool = False) -> tuple[float, Floats]:
        """Loss and unknowns at a shape, of all pairs or of the sample."""
        columns, target = (self.sample if sample else self.whole).tabulate(np.array([shape]))
        if not len(self.freedom.lower):
            return measure_pinball(target[0], self.tau), np.empty(0)
        guess = self.guess.get(sample)
        found = solve_quantile(columns[0], target[0], self.freedom, self.tau, guess)
        self.guess[sample] = found
        return measure_pinball(target[0] - found @ columns[0], self.tau), found

    def measure(self, shape: float, sample: bool = False) -> float:
        """Loss at a trial shape; infinite where none is found, so that the search goes on."""
        try:
            return self.solve(shape, sample)[0]
        except BadInput:
            return np.inf

    def find_shape(self) -> float:
        """The shape with the least loss of all pairs.

        Raises
        ------
        BadInput
            No trial shape has a curve.
        """
        scan = self.model.search(self.pairs.angle)
        scan = scan[np.unique(np.append(np.arange(0, len(scan), STRIDE), len(scan) - 1))]
        loss = np.array([self.measure(float(shape), sample=True) for shape in scan])
        if not np.isfinite(loss).any():
            raise BadInput("The quantile cannot be fitted at any trial shape.")
        walled = np.concatenate(([np.inf], loss, [np.inf]))
        dips = np.flatnonzero((loss < walled[:-2]) & (loss <= walled[2:]))
        dips = dips[loss[dips] <= CLOSE * loss.min()]
        best = dips[np.argsort(loss[dips], kind="stable")[:CANDIDATES]]
        return min(self._refine(scan, int(place)) for place in best)[1]

    def _refine(self, scan: Floats, place: int) -> tuple[float, float]:
        """Least loss of all pairs about a trial shape, and where it is."""
        from scipy.optimize import minimize_scalar

        self.guess.pop(False, None)
        low, high = scan[max(place - 1, 0)], scan[min(place + 1, len(scan) - 1)]
        found = minimize_scalar(
            lambda shape: self.measure(float(shape)),
            bounds=(low, high),
            method="bounded",
            options={"maxiter": REFINEMENTS, "xatol": 1e-8 * high},
        )
        at = [float(found.x), *(float(end) for end in (low, scan[place], high))]
        return min((self.measure(shape), shape) for shape in at)


def arrange(pairs: Pairs) -> Pairs:
    """The same pairs so that every kth is a sample even in angle and, at like angles, in value."""
    by_angle = np.lexsort((pairs.value, pairs.angle))
    slices = np.empty(len(pairs), np.int64)
    slices[by_angle] = np.arange(len(pairs)) * SLICES // len(pairs)
    order = np.lexsort((pairs.angle, pairs.value, slices))
    return Pairs(
        pairs.angle[order], pairs.value[order], pairs.weight[order], pairs.scale,
        pairs.weight_scale, pairs.warnings,
    )  # fmt: skip


def _covary_edge(jacobian: Floats, residual: Floats, tau: float) -> Floats:
    """Powell's sandwich: τ(1 − τ)·H⁻¹·JᵀJ·H⁻¹, H the same product over pairs near the edge.

    The band is that of Hall and Sheather, J. R. Stat. Soc. B 50 (1988) 381, in units of the
    residuals' spread.
    """
    from scipy.special import ndtri

    n, p = jacobian.shape
    z = ndtri(tau)
    density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    width = n ** (-1 / 3) * ndtri(0.975) ** (2 / 3)
    width *= (1.5 * density**2 / (2 * z**2 + 1)) ** (1 / 3)
    width = min(width, 0.9 * tau, 0.9 * (1 - tau))
    low, high = np.quantile(residual, [0.25, 0.75])
    spread = min(float(residual.std()), (high - low) / 1.34) or float(residual.std())
    band = spread * (ndtri(tau + width) - ndtri(tau - width)) / 2
    near = np.abs(residual) <= band
    if near.sum() < FEWEST_NEAR * p or band == 0.0:
        return np.full((p, p), np.nan)
    size = np.sqrt((jacobian**2).sum(axis=0))
    size[size == 0.0] = 1.0
    unit = jacobian / size
    bread = unit[near].T @ unit[near] / (2 * band)
    if np.linalg.cond(bread) > 1e12:
        return np.full((p, p), np.nan)
    inverse = np.linalg.inv(bread)
    covariance = tau * (1 - tau) * inverse @ (unit.T @ unit) @ inverse
    return np.asarray(covariance / np.outer(size, size))
