"""What every angular model can do, whatever its formula: be drawn, inverted and fitted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.phase.inversion import find_monotone_interval, invert_monotone
from app.core.phase.parameter import Parameter

RIGHT_ANGLE = np.pi / 2


@dataclass(frozen=True)
class AngularModel(ABC):
    """A return that depends on the angle. Angles are radians.

    Attributes
    ----------
    name : str
        Key in the registry, on the command line and in files.
    title, formula, source : str
    parameters : tuple of Parameter
    unknown_when : mapping of str to str
        Why a parameter can be undetermined.
    extrapolates : bool
        The curve means something beyond the angles that it was fitted to.
    """

    name: str
    title: str
    formula: str
    source: str
    parameters: tuple[Parameter, ...]
    unknown_when: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    extrapolates: bool = field(default=False, kw_only=True)

    @abstractmethod
    def evaluate(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """I(ω), of the shape of `angle`; an undetermined parameter may be NaN or missing."""

    @abstractmethod
    def slope(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """dI/dω per radian; σ_ω = σ_I / |slope|."""

    @abstractmethod
    def jacobian(self, angle: Floats, values: Mapping[str, float], names: Sequence[str]) -> Floats:
        """dI/dparameter for the parameters in `names`, (n, len(names))."""

    def accepts(self, angle: Floats) -> Bools:
        """Angles that the model is defined for: 0 ≤ ω < 90°."""
        return (angle >= 0.0) & (angle < RIGHT_ANGLE)

    def reach(self, values: Mapping[str, float]) -> float:
        """Angle beyond which the curve must not be inverted."""
        return RIGHT_ANGLE

    def remark(
        self,
        values: Mapping[str, float],
        angle: Floats,
        noise: float,
        fixed: Mapping[str, float],
    ) -> tuple[str, ...]:
        """Sentences that a user should read beside a fit.

        Parameters
        ----------
        values : mapping of str to float
        angle : (n,) array
            The angles fitted.
        noise : float
            Standard deviation of the residuals.
        fixed : mapping of str to float
            Parameters that were not fitted.
        """
        return ()

    def random(self, generator: np.random.Generator, scale: float = 1.0) -> dict[str, float]:
        """Parameters drawn evenly from their usual ranges; those that scale times `scale`."""
        return {
            p.name: float(generator.uniform(*p.typical)) * (scale if p.scales else 1.0)
            for p in self.parameters
        }

    def start_values(self, scale: float = 1.0) -> dict[str, float]:
        """Where a search begins that needs a start, for values of size `scale`."""
        return {p.name: p.start * (scale if p.scales else 1.0) for p in self.parameters}

    def monotone_interval(
        self, values: Mapping[str, float], within: tuple[float, float] = (0.0, RIGHT_ANGLE)
    ) -> tuple[float, float] | None:
        """Widest interval of angle on which I(ω) only falls or only rises; None if flat."""
        start, stop = within[0], min(within[1], self.reach(values))
        return find_monotone_interval(lambda angle: self.slope(angle, values), start, stop)

    def inverse(
        self,
        value: Floats,
        values: Mapping[str, float],
        within: tuple[float, float] = (0.0, RIGHT_ANGLE),
    ) -> Floats:
        """ω from I on `monotone_interval`; NaN where I is not reached there."""
        value = np.asarray(value, dtype=np.float64)
        interval = self.monotone_interval(values, within)
        if interval is None:
            return np.full(value.shape, np.nan)
        return invert_monotone(
            lambda angle: self.evaluate(angle, values),
            lambda angle: self.slope(angle, values),
            value,
            interval,
        )
