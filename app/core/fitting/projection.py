"""Variable projection: for each shape the linear part is solved, so only the shape is sought.

Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413. The search is global over the bounds
of the one shape, so that nobody has to guess start values.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.core.arrays import Floats
from app.core.fitting.linear import solve_bounded
from app.core.fitting.pairs import Pairs, condense
from app.core.phase import PhaseModel
from app.core.phase.model import Freedom, combine

SEARCH_BINS = 512
CANDIDATES = 4
# Dips of the condensed data that differ by less may be in another order in all of the data.
CLOSE = 1.01
# Share of the shape by which the condensed data may misplace the minimum at first.
MISPLACED = 1e-3


@dataclass(frozen=True, eq=False)
class Projection:
    """The sum of squares of a model as a function of its shape alone."""

    model: PhaseModel
    pairs: Pairs
    freedom: Freedom

    @cached_property
    def root(self) -> Floats:
        """Root of the weights, (n,)."""
        return np.sqrt(self.pairs.weight)

    def solve(self, shape: Floats | float) -> tuple[Floats, Floats]:
        """Coefficients (..., k) and weighted residuals (..., n) for shapes (...)."""
        spread = shape[:, None] if isinstance(shape, np.ndarray) else shape
        columns = self.model.basis(self.pairs.angle, spread)
        stack = np.stack(np.broadcast_arrays(*columns), axis=-2)
        stack *= self.root
        offset, directions = self.freedom.offset, self.freedom.directions
        free, residual = solve_bounded(
            np.einsum("kj,...kn->...jn", directions, stack),
            self.pairs.value * self.root - np.einsum("k,...kn->...n", offset, stack),
            self.freedom.lower,
            self.freedom.upper,
        )
        return offset + free @ directions.T, residual

    def rss(self, shape: Floats | float) -> Floats:
        """Weighted sum of squares, (...,), of the normalised values."""
        residual = self.solve(shape)[1]
        squares: Floats = np.einsum("...n,...n->...", residual, residual)
        return squares

    def gradient(self, shape: float) -> float:
        """Half the derivative of `rss` by the shape.

        At the linear optimum the coefficients' own change has no effect.
        """
        coefficients, residual = self.solve(shape)
        angle = self.pairs.angle
        bend = combine(coefficients, self.model.basis_by_shape(angle, shape), angle)
        # Not @: a threaded BLAS waits longer than such a product takes.
        return -float(np.einsum("n,n,n->", residual, self.root, bend))


def project(
    model: PhaseModel, pairs: Pairs, freedom: Freedom, fixed: Mapping[str, float]
) -> tuple[Floats, float]:
    """Best coefficients, (k,), and shape (NaN for a model without one)."""
    projection = Projection(model, pairs, freedom)
    shape = fixed.get(model.shape, np.nan)
    if model.shape and model.shape not in fixed:
        shape = _find_shape(projection)
    return projection.solve(shape)[0], shape


def _find_shape(projection: Projection) -> float:
    model, pairs = projection.model, projection.pairs
    scan = model.search(pairs.angle)
    rough = Projection(model, condense(pairs, SEARCH_BINS), projection.freedom)
    found = sorted(_refine(rough, near) for near in _bracket_dips(scan, rough.rss(scan)))
    if rough.pairs is not pairs:
        close = [shape for cost, shape in found if cost <= CLOSE * found[0][0]]
        found = sorted(_refine(projection, _surround(scan, projection, s)) for s in close)
    return found[0][1]


def _bracket_dips(scan: Floats, rss: Floats) -> Iterator[Floats]:
    """The deepest dips of a scan, each with its neighbours; a plateau counts once."""
    walled = np.concatenate(([np.inf], rss, [np.inf]))
    dips = np.flatnonzero((rss < walled[:-2]) & (rss <= walled[2:]))
    for i in dips[np.argsort(rss[dips], kind="stable")[:CANDIDATES]]:
        yield scan[max(i - 1, 0) : i + 2]


def _surround(scan: Floats, projection: Projection, shape: float) -> tuple[float, ...]:
    """A bracket around a minimum that is known well but not quite."""
    share, lowest, highest = MISPLACED, float(scan[0]), float(scan[-1])
    while True:
        low, high = max(shape * (1 - share), lowest), min(shape * (1 + share), highest)
        falls_in = low == lowest or projection.gradient(low) <= 0
        if (falls_in and (high == highest or projection.gradient(high) >= 0)) or share >= 1:
            return low, high
        share *= 10


def _refine(projection: Projection, near: Sequence[float] | Floats) -> tuple[float, float]:
    """Least sum of squares between neighbouring shapes, and where it is."""
    from scipy.optimize import brentq

    shapes = [float(shape) for shape in near]
    slopes = [projection.gradient(shape) for shape in shapes]
    # The zero of the gradient is known to full precision, the minimum itself to half of it.
    roots = [
        float(brentq(projection.gradient, *ends, xtol=1e-15, rtol=1e-14))
        for ends, (falling, rising) in zip(
            itertools.pairwise(shapes), itertools.pairwise(slopes), strict=True
        )
        if falling < 0 < rising
    ]
    return min((float(projection.rss(shape)), shape) for shape in (*roots, *shapes))
