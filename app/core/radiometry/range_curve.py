"""The range effect as measured: a curve through a reference panel at many ranges."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, Literal

import msgspec
import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.range_effect import check_reference
from app.core.radiometry.step import Step, spread

Scale = Literal["additive", "multiplicative"]
NUDGE = 1e-6
"""Relative step of the numerical derivatives of a spline by its levels."""


class RangeCurve(Step, frozen=True, dict=True):
    """A curve F(d) through levels at ranges: y = x + F(d), or y = x · F(d).

    Additive for logarithmic instruments, where weaker light is a shift (Balduzzi 2011),
    multiplicative for linear ones. At the reference range, which is one of the ranges, F is 0
    or 1 and not free: a shift of the whole curve belongs to the response.

    Attributes
    ----------
    scale : {'additive', 'multiplicative'}
    ranges : tuple of float
        Metres, rising; the curve is known between the first and the last.
    levels : tuple of float
        F at these ranges.
    reference : float
        Metres.
    """

    scale: Scale
    ranges: tuple[float, ...]
    levels: tuple[float, ...]
    reference: float

    def __post_init__(self) -> None:
        check_reference(self.reference)
        if len(self.ranges) != len(self.levels) or len(self.ranges) < 2:
            raise WrongUse("A range curve needs as many levels as ranges, and two at least.")
        if not all(0.0 < near < far < np.inf for near, far in pairwise(self.ranges)):
            raise WrongUse("The ranges of a range curve must rise.")
        if self.reference not in self.ranges:
            raise WrongUse(
                f"The reference range of {self.reference:g} m is none of the curve's ranges."
            )
        if not all(np.isfinite(self.levels)):
            raise WrongUse("The levels of a range curve must be finite numbers.")
        if self.scale == "multiplicative" and min(self.levels) <= 0.0:
            raise BadInput("A multiplicative range curve must stay above zero.")

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"F({near:g} m)" for near in self.ranges if near != self.reference)

    def values(self) -> Floats:
        return np.array(self.levels, float)[self._open]

    def with_values(self, values: Floats) -> Any:
        levels = np.full(len(self.ranges), 0.0 if self.scale == "additive" else 1.0)
        levels[self._open] = values
        return msgspec.structs.replace(self, levels=tuple(map(float, levels)))

    @cached_property
    def _open(self) -> Ints:
        return np.flatnonzero(np.array(self.ranges) != self.reference).astype(np.int64)

    def respond(self, x: Floats, distance: Floats) -> Floats:
        level = self.level(distance)
        return np.asarray(x + level if self.scale == "additive" else x * level)

    def invert(self, y: Floats, distance: Floats) -> Floats:
        level = self.level(distance)
        return np.asarray(y - level if self.scale == "additive" else y / level)

    def slope(self, x: Floats, distance: Floats) -> Floats:
        level = self.level(distance)
        additive = self.scale == "additive"
        return spread(np.where(np.isnan(level), np.nan, 1.0) if additive else level, x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        shares = self.shares(distance)[self._open]
        scaled = shares if self.scale == "additive" else shares * x
        shape = spread(x, x, distance).shape
        return np.asarray(np.broadcast_to(scaled, (len(scaled), *shape)))

    def range_slope(self, x: Floats, distance: Floats) -> Floats:
        rise = self.rise(distance)
        return spread(rise if self.scale == "additive" else rise * x, x, distance)

    def level(self, distance: Floats) -> Floats:
        """F at a distance; NaN outside the ranges."""
        raise NotImplementedError

    def rise(self, distance: Floats) -> Floats:
        """Derivative of F by the distance."""
        raise NotImplementedError

    def shares(self, distance: Floats) -> Floats:
        """Derivative of F by each of its levels, (k, n)."""
        raise NotImplementedError

    def within(self, distance: Floats) -> Floats:
        """The distance where the curve is known, NaN elsewhere."""
        away = np.asarray(distance, float)
        known = (away >= self.ranges[0]) & (away <= self.ranges[-1])
        return np.where(known, away, np.nan)


class PolynomialCurve(RangeCurve, frozen=True, dict=True):
    """Piecewise polynomial of order 1 or 2 (Balduzzi 2011, 2.2).

    Order 1: a piece between each two ranges. Order 2: a parabola through three ranges at a
    time, so that their number is odd. The pieces meet.

    Attributes
    ----------
    order : {1, 2}
    """

    title: ClassVar[str] = "Piecewise polynomial over range"
    source: ClassVar[str] = "Balduzzi et al. 2011, equation 7"

    order: Literal[1, 2] = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if (len(self.ranges) - 1) % self.order:
            raise WrongUse("A curve of order 2 needs an odd number of ranges.")

    def level(self, distance: Floats) -> Floats:
        return np.asarray(self._whole(self.within(distance)))

    def rise(self, distance: Floats) -> Floats:
        return np.asarray(self._whole(self.within(distance), 1))

    @cached_property
    def _whole(self):  # type: ignore[no-untyped-def]
        from scipy.interpolate import PPoly

        ranges, levels = np.array(self.ranges), np.array(self.levels)
        ends = ranges[:: self.order]
        pieces = [slice(k, k + self.order + 1) for k in range(0, len(ranges) - 1, self.order)]
        each = [np.polyfit(ranges[p] - ranges[p.start], levels[p], self.order) for p in pieces]
        return PPoly(np.array(each).T, ends, extrapolate=False)

    def shares(self, distance: Floats) -> Floats:
        nodes, basis = self._pieces(distance)
        each = np.arange(len(self.ranges)).reshape(-1, *(1,) * (nodes.ndim - 1))
        result = np.zeros((len(self.ranges), *nodes.shape[1:]))
        for node, share in zip(nodes, basis, strict=True):
            result += np.where(node == each, share, 0.0)
        return np.where(np.isnan(basis[0]), np.nan, result)

    def _pieces(self, distance: Floats) -> tuple[Ints, Floats]:
        """Nodes of each distance's piece, and Lagrange's polynomials there."""
        away, ranges = self.within(distance), np.array(self.ranges)
        piece = np.searchsorted(ranges[:: self.order], away, "right") - 1
        last = (len(ranges) - 1) // self.order - 1
        first = self.order * np.clip(piece, 0, last).astype(np.int64)
        nodes = np.stack([first + i for i in range(self.order + 1)])
        return nodes, _lagrange(ranges[nodes], away)


def _lagrange(at: Floats, x: Floats) -> Floats:
    basis = np.ones(at.shape)
    for i in range(len(at)):
        for j in range(len(at)):
            if j != i:
                basis[i] = basis[i] * (x - at[j]) / (at[i] - at[j])
    return basis


class SplineCurve(RangeCurve, frozen=True, dict=True):
    """Monotone cubic spline (PCHIP) through the levels: it never swings beyond them."""

    title: ClassVar[str] = "Monotone spline over range"
    source: ClassVar[str] = "Fritsch and Butland 1984"

    def level(self, distance: Floats) -> Floats:
        return np.asarray(self._spline(self.within(distance)))

    def rise(self, distance: Floats) -> Floats:
        return np.asarray(self._spline(self.within(distance), 1))

    def shares(self, distance: Floats) -> Floats:
        away = self.within(distance)
        size = NUDGE * max(1.0, float(np.ptp(self.levels)))
        return np.stack(
            [
                (self._nudged(i, size)(away) - self._nudged(i, -size)(away)) / (2.0 * size)
                for i in range(len(self.levels))
            ]
        )

    @cached_property
    def _spline(self):  # type: ignore[no-untyped-def]
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.ranges, self.levels, extrapolate=False)

    def _nudged(self, which: int, size: float):  # type: ignore[no-untyped-def]
        from scipy.interpolate import PchipInterpolator

        levels = np.array(self.levels)
        levels[which] += size
        return PchipInterpolator(self.ranges, levels, extrapolate=False)
