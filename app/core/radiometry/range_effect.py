"""How light weakens with range, as formulas: inverse square, and Hancock's two forms."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.core.radiometry.step import Step, spread

Form = Literal["outer", "inner"]


class InverseSquare(Step, frozen=True):
    """y = x · (reference / d)²: an ideal instrument (Balduzzi 2011, equation 2).

    Attributes
    ----------
    reference : float
        Range at which x and y are the same, metres.
    """

    title: ClassVar[str] = "Inverse square of the range"
    source: ClassVar[str] = "Balduzzi et al. 2011, equation 2"

    reference: float

    def __post_init__(self) -> None:
        check_reference(self.reference)

    def respond(self, x: Floats, distance: Floats) -> Floats:
        return np.asarray(x * self._strength(distance))

    def invert(self, y: Floats, distance: Floats) -> Floats:
        return np.asarray(y / self._strength(distance))

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(self._strength(distance), x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        return np.empty((0, *spread(x, x, distance).shape))

    def range_slope(self, x: Floats, distance: Floats) -> Floats:
        return np.asarray(-2.0 * x * self._strength(distance) / distance)

    def _strength(self, distance: Floats) -> Floats:
        away = np.asarray(distance, float)
        known = np.where((away > 0.0) & (away < np.inf), away, np.nan)
        return np.asarray((self.reference / known) ** 2)


class AnalyticRange(Step, frozen=True):
    """y = x · g(d) / g(reference), with g of Hancock et al. 2017, equation A5.

    The print is ambiguous, so that both readings have a name: ``outer`` is
    g = d^(−a) · (1 − e^(−k2·d))^k3, ``inner`` is g = d^(−a) · (1 − e^(−k2·d^k3)).

    Attributes
    ----------
    a, k2, k3 : float
    form : {'outer', 'inner'}
    reference : float
        Range at which x and y are the same, metres: that of the fixed panel.
    nearest, farthest : float
        Ranges that it was calibrated for, metres; g grows without bound towards 0.
    """

    free: ClassVar[tuple[str, ...]] = ("a", "k2", "k3")
    title: ClassVar[str] = "Analytic range effect"
    source: ClassVar[str] = "Hancock et al. 2017, equation A5"

    a: float
    k2: float
    k3: float
    form: Form = "outer"
    reference: float = 8.0
    nearest: float = 2.0
    farthest: float = 60.0

    def __post_init__(self) -> None:
        if not all(np.isfinite((self.a, self.k2, self.k3))) or min(self.k2, self.k3) <= 0.0:
            raise WrongUse(
                f"An analytic range effect needs positive k2 and k3, not {self.k2:g} and "
                f"{self.k3:g}."
            )
        check_reference(self.reference)
        if not 0.0 < self.nearest <= self.reference <= self.farthest < np.inf:
            raise WrongUse(
                f"The reference range of {self.reference:g} m does not lie within the calibrated "
                f"{self.nearest:g} to {self.farthest:g} m."
            )

    def respond(self, x: Floats, distance: Floats) -> Floats:
        return np.asarray(x * self._strength(distance))

    def invert(self, y: Floats, distance: Floats) -> Floats:
        return np.asarray(y / self._strength(distance))

    def slope(self, x: Floats, distance: Floats) -> Floats:
        return spread(self._strength(distance), x, distance)

    def gradient(self, x: Floats, distance: Floats) -> Floats:
        away = self._within(distance)
        relative = self._relative_gradient(away) - self._relative_gradient(
            np.array(self.reference)
        ).reshape(3, *(1,) * away.ndim)
        return np.asarray(self.respond(x, distance) * relative)

    def range_slope(self, x: Floats, distance: Floats) -> Floats:
        away = self._within(distance)
        if self.form == "outer":
            rise = self.k3 * self.k2 / np.expm1(self.k2 * away)
        else:
            u = self.k2 * away**self.k3
            rise = u * self.k3 / away / np.expm1(u)
        return np.asarray(self.respond(x, distance) * (rise - self.a / away))

    def _strength(self, distance: Floats) -> Floats:
        known = self._within(distance)
        return np.asarray(np.exp(self._log_g(known) - self._log_g(np.array(self.reference))))

    def _within(self, distance: Floats) -> Floats:
        """The distance where the effect is known, NaN elsewhere."""
        away = np.asarray(distance, float)
        return np.where((away >= self.nearest) & (away <= self.farthest), away, np.nan)

    def _log_g(self, away: Floats) -> Floats:
        if self.form == "outer":
            rise = self.k3 * np.log(-np.expm1(-self.k2 * away))
        else:
            rise = np.log(-np.expm1(-self.k2 * away**self.k3))
        return np.asarray(rise - self.a * np.log(away))

    def _relative_gradient(self, away: Floats) -> Floats:
        """Derivative of ln g by a, k2 and k3, (3, n)."""
        log = np.log(away)
        if self.form == "outer":
            by_k2 = self.k3 * away / np.expm1(self.k2 * away)
            by_k3 = np.log(-np.expm1(-self.k2 * away))
        else:
            power = away**self.k3
            by_k2 = power / np.expm1(self.k2 * power)
            by_k3 = by_k2 * self.k2 * log
        return np.stack([-log, by_k2, by_k3])


def check_reference(reference: float) -> None:
    """Refuse (`WrongUse`) a reference range that is not a positive number of metres."""
    if not 0.0 < reference < np.inf:
        raise WrongUse(f"A reference range must be a positive number of metres, not {reference}.")
