"""Variable projection: for each shape the linear part is solved, so only the shape is sought.

Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from app.core.arrays import Floats, Ints
from app.core.fitting.linear import solve_bounded
from app.core.phase import PhaseModel
from app.core.phase.model import Freedom


@dataclass(frozen=True, eq=False)
class Projection:
    """The sums of squares of groups of pairs as functions of their shapes alone.

    Attributes
    ----------
    model : PhaseModel
    angle : (g or 1, n) array
        Radians.
    value : (g, n) array
        Normalised.
    root : (g or 1, n) array
        Root of the weights; 0 for what only fills up a short group.
    freedom : Freedom
        With a leading axis of g or 1.
    """

    model: PhaseModel
    angle: Floats
    value: Floats
    root: Floats
    freedom: Freedom

    def __len__(self) -> int:
        return len(self.value)

    @cached_property
    def is_free(self) -> bool:
        """Whether the coefficients are the unknowns themselves."""
        directions = self.freedom.directions
        square = directions.shape[-2] == directions.shape[-1]
        return bool(
            square
            and not self.freedom.offset.any()
            and (directions == np.eye(len(directions[0]))).all()
        )

    @cached_property
    def is_even(self) -> bool:
        """Whether all weights are 1."""
        return bool((self.root == 1.0).all())

    def take(self, rows: Ints) -> Projection:
        """The groups `rows`, which may be repeated."""

        def choose(array: Floats) -> Floats:
            return array if len(array) == 1 else array[rows]

        f = self.freedom
        freedom = Freedom(*map(choose, (f.offset, f.directions, f.lower, f.upper)))
        return Projection(
            self.model, choose(self.angle), self.value[rows], choose(self.root), freedom
        )

    def tabulate(self, shape: Floats) -> tuple[Floats, Floats]:
        """Columns of the unknowns, (..., j, n), and what they must make up, (..., n); no weights.

        Parameters
        ----------
        shape : (g or 1,) or (g or 1, s) array
        """
        angle, value = (_widen(a, shape.ndim - 1) for a in (self.angle, self.value))
        columns = self.model.basis(angle, shape[..., None])
        stack = np.stack(np.broadcast_arrays(*columns), axis=-2)
        if self.is_free:
            return stack, value
        offset = _widen(self.freedom.offset, shape.ndim - 1)
        directions = _widen(self.freedom.directions, shape.ndim - 1, 2)
        return (
            np.einsum("...kj,...kn->...jn", directions, stack),
            value - np.einsum("...k,...kn->...n", offset, stack),
        )

    def solve(self, shape: Floats) -> tuple[Floats, Floats]:
        """Coefficients (..., k) and weighted residuals (..., n) for shapes (g,) or (g, s)."""
        more = shape.ndim - 1
        columns, target = self.tabulate(shape)
        if not self.is_even:
            root = _widen(self.root, more)
            columns, target = columns * root[..., None, :], target * root
        lower, upper = (_widen(b, more) for b in (self.freedom.lower, self.freedom.upper))
        free, residual = solve_bounded(columns, target, lower, upper)
        if self.is_free:
            return free, residual
        turned = np.einsum("...kj,...j->...k", _widen(self.freedom.directions, more, 2), free)
        return _widen(self.freedom.offset, more) + turned, residual

    def rss(self, shape: Floats) -> Floats:
        """Weighted sums of squares, (g,) or (g, s), of the normalised values."""
        residual = self.solve(shape)[1]
        squares: Floats = np.einsum("...n,...n->...", residual, residual)
        return squares

    def gradient(self, shape: Floats) -> Floats:
        """Half the derivative of `rss` by the shape.

        At the linear optimum the coefficients' own change has no effect.
        """
        coefficients, residual = self.solve(shape)
        more = shape.ndim - 1
        bend = combine_rows(
            coefficients,
            self.model.basis_by_shape(_widen(self.angle, more), shape[..., None]),
        )
        if not self.is_even:
            residual *= _widen(self.root, more)
        fall: Floats = np.einsum("...n,...n->...", residual, bend)
        return -fall


def combine_rows(weights: Floats, columns: tuple[npt.ArrayLike, ...]) -> Floats:
    """Σ weights[..., i]·columns[i] for groups side by side, (..., n)."""
    parts = [
        np.where(w == 0.0, 0.0, w) * column
        for w, column in zip(np.moveaxis(weights, -1, 0)[..., None], columns, strict=True)
    ]
    total: Floats = np.asarray(parts[0])
    for part in parts[1:]:
        total = total + part
    return total


def _widen(array: Floats, more: int, inner: int = 1) -> Floats:
    """Put `more` axes of length 1 before the last `inner`."""
    if not more:
        return array
    cut = array.ndim - inner
    return array.reshape(*array.shape[:cut], *([1] * more), *array.shape[cut:])
