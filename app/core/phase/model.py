"""What an angular model is: a sum of columns, most of its parameters linear.

I(ω) = Σ cᵢ · Bᵢ(ω; shape), where at most one parameter, the shape, is not linear. That is
all the fit needs to find the best curve without start values (variable projection).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.phase.inversion import find_monotone_interval, invert_monotone

Columns = tuple[Any, ...]
RIGHT_ANGLE = np.pi / 2
AT_BOUND = 1e-9


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a model, as results and sliders show it.

    Attributes
    ----------
    name, unit, meaning : str
        `unit` is ``1`` for a pure number and ``value`` for the unit of the data.
    typical : (float, float)
        Usual range, for sliders and tests; in units of the largest value if `scales`.
    lower, upper : float
        Bounds of a fit.
    scales : bool
        Proportional to the data: I → c·I makes it c times as large.
    wraps : bool
        One bound continues at the other: to lie on it means nothing.
    """

    name: str
    unit: str
    meaning: str
    typical: tuple[float, float]
    lower: float = -np.inf
    upper: float = np.inf
    scales: bool = False
    wraps: bool = False

    def touches_bound(self, value: float) -> bool:
        """Whether `value` lies on a bound; for one that scales, in units of the data's size."""
        return not self.wraps and min(abs(value - self.lower), abs(value - self.upper)) <= AT_BOUND


@dataclass(frozen=True, slots=True)
class Reference:
    """Parameters that a paper prints for a sample."""

    sample: str
    values: Mapping[str, float]
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Freedom:
    """What fixed parameters leave free: c = offset + directions @ free, within bounds.

    Attributes
    ----------
    offset : (k,) array
    directions : (k, j) array
    lower, upper : (j,) arrays
    """

    offset: Floats
    directions: Floats
    lower: Floats
    upper: Floats


@dataclass(frozen=True)
class PhaseModel(ABC):
    """An angular model of the return ("phase function").

    The methods here suit a model whose linear parameters are its coefficients, in the same
    order; a model that mixes them overrides `coefficients`, `coefficient_slopes`, `name_values`
    and `free`. Angles are radians; parameters are in the units that `parameters` names.

    Attributes
    ----------
    name : str
        Key in the registry, on the command line and in files.
    title, formula, source : str
    parameters : tuple of Parameter
        The shape, where there is one, comes last.
    shape : str
        Name of the parameter that is not linear; empty when all are.
    extrapolates : bool
        The curve means something beyond the angles that it was fitted to.
    unknown_when : mapping of str to str
        Why a parameter can be undetermined.
    references : tuple of Reference
    """

    name: str
    title: str
    formula: str
    source: str
    parameters: tuple[Parameter, ...]
    shape: str = ""
    extrapolates: bool = False
    unknown_when: Mapping[str, str] = field(default_factory=dict)
    references: tuple[Reference, ...] = field(default=(), repr=False)

    # The science, model by model.

    @abstractmethod
    def basis(self, angle: Floats, shape: Any) -> Columns:
        """Columns Bᵢ, k of them; `angle` and `shape` broadcast."""

    @abstractmethod
    def basis_by_angle(self, angle: Floats, shape: Any) -> Columns:
        """Columns dBᵢ/dω, per radian."""

    def basis_by_shape(self, angle: Floats, shape: Any) -> Columns:
        """Columns dBᵢ/dshape; asked only of models that have a shape."""
        raise NotImplementedError(f"{self.name} has no shape to vary ({shape}).")

    def search(self, angle: Floats) -> Floats:
        """Values of the shape that bracket every minimum, (s,), for fits to `angle`."""
        raise NotImplementedError(f"{self.name} has no shape to search ({len(angle)} angles).")

    def coefficients(self, values: Mapping[str, float]) -> Floats:
        """Coefficients cᵢ of the columns, (k,), from named parameters."""
        return np.array([values[p.name] for p in self.linear_parameters])

    def coefficient_slopes(self, values: Mapping[str, float]) -> Floats:
        """dcᵢ/dparameter, (k, linear parameters)."""
        return np.eye(len(self.linear_parameters))

    def name_values(
        self,
        coefficients: Floats,
        shape: float,
        fixed: Mapping[str, float],
    ) -> dict[str, float]:
        """Named parameters from coefficients; NaN marks one that they leave undetermined."""
        names = [p.name for p in self.linear_parameters]
        values = dict(zip(names, map(float, coefficients), strict=True))
        return values | {self.shape: shape} if self.shape else values

    def free(self, fixed: Mapping[str, float]) -> Freedom:
        """How fixed parameters restrict the coefficients."""
        linear = self.linear_parameters
        offset = np.array([fixed.get(p.name, 0.0) for p in linear])
        moving = [i for i, p in enumerate(linear) if p.name not in fixed]
        return Freedom(
            offset,
            np.eye(len(linear))[:, moving],
            np.array([linear[i].lower for i in moving]),
            np.array([linear[i].upper for i in moving]),
        )

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

    # What every model can do.

    @property
    def linear_parameters(self) -> tuple[Parameter, ...]:
        """All parameters but the shape."""
        return tuple(p for p in self.parameters if p.name != self.shape)

    def evaluate(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """I(ω), of the shape of `angle`; an undetermined parameter may be NaN or missing."""
        return self._sum(self.basis, angle, values)

    def slope(self, angle: Floats, values: Mapping[str, float]) -> Floats:
        """dI/dω per radian; σ_ω = σ_I / |slope|."""
        return self._sum(self.basis_by_angle, angle, values)

    def jacobian(self, angle: Floats, values: Mapping[str, float], names: Sequence[str]) -> Floats:
        """dI/dparameter for the parameters in `names`, (n, len(names))."""
        shape = values.get(self.shape, np.nan)
        columns = self.basis(angle, shape)
        slopes = self.coefficient_slopes(values)
        order = {p.name: i for i, p in enumerate(self.linear_parameters)}
        by_shape = self.basis_by_shape(angle, shape) if self.shape in names else ()
        weights = self.coefficients(values)
        return np.stack(
            [
                combine(weights, by_shape, angle)
                if name == self.shape
                else combine(slopes[:, order[name]], columns, angle)
                for name in names
            ],
            axis=-1,
        )

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

    def _sum(self, basis: Any, angle: Floats, values: Mapping[str, float]) -> Floats:
        angle = np.asarray(angle, dtype=np.float64)
        columns = basis(angle, values.get(self.shape, np.nan))
        return combine(self.coefficients(values), columns, angle)


def combine(weights: Floats, columns: Columns, angle: Floats) -> Floats:
    """Σ weightᵢ·columnᵢ, of the shape of `angle`."""
    total = np.zeros(np.shape(angle))
    for weight, column in zip(weights, columns, strict=True):
        # A column without weight may be undefined: with k_d = 1 there is no m.
        if weight != 0.0:
            total = total + weight * column
    return total
