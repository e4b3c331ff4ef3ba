"""What a model of the registry is: a sum of columns, most of its parameters linear.

I(ω) = Σ cᵢ · Bᵢ(ω; shape), where at most one parameter, the shape, is not linear. That is
all the fit needs to find the best curve without start values (variable projection).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.phase.angular import RIGHT_ANGLE, AngularModel
from app.core.phase.parameter import Parameter

__all__ = [
    "RIGHT_ANGLE",
    "Columns",
    "Freedom",
    "Parameter",
    "PhaseModel",
    "Reference",
    "combine",
    "pile",
]

Columns = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Reference:
    """Parameters that a paper prints for a sample."""

    sample: str
    values: Mapping[str, float]
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Freedom:
    """What fixed parameters leave free: c = offset + directions @ free, within bounds.

    All arrays may have a leading axis over groups.

    Attributes
    ----------
    offset : (..., k) array
    directions : (..., k, j) array
    lower, upper : (..., j) arrays
    """

    offset: Floats
    directions: Floats
    lower: Floats
    upper: Floats


@dataclass(frozen=True)
class PhaseModel(AngularModel):
    """An angular model of the return ("phase function").

    The methods here suit a model whose linear parameters are its coefficients, in the same
    order; a model that mixes them overrides `coefficients`, `coefficient_slopes`, `name_values`
    and `free`. Angles are radians; parameters are in the units that `parameters` names.
    Parameters and shapes may be arrays, (g,), one for each of g groups.

    Attributes
    ----------
    parameters : tuple of Parameter
        The shape, where there is one, comes last.
    shape : str
        Name of the parameter that is not linear; empty when all are.
    references : tuple of Reference
    fixed_with : mapping of str to str
        Parameters that can be fixed only together with another.
    """

    shape: str = ""
    references: tuple[Reference, ...] = field(default=(), repr=False)
    fixed_with: Mapping[str, str] = field(default_factory=dict, repr=False)

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
        """Values of the shape that bracket every minimum, (..., s); `angle` is (..., n)."""
        raise NotImplementedError(f"{self.name} has no shape to search ({len(angle)} angles).")

    def coefficients(self, values: Mapping[str, Any]) -> Floats:
        """Coefficients cᵢ of the columns, (..., k), from named parameters."""
        return pile([values[p.name] for p in self.linear_parameters])

    def coefficient_slopes(self, values: Mapping[str, Any]) -> Floats:
        """dcᵢ/dparameter, (..., k, linear parameters)."""
        return np.eye(len(self.linear_parameters))

    def name_values(
        self,
        coefficients: Floats,
        shape: Any,
        fixed: Mapping[str, Any],
    ) -> dict[str, Any]:
        """Named parameters, (...), from coefficients, (..., k), and shapes, (...).

        NaN marks one that they leave undetermined.
        """
        names = [p.name for p in self.linear_parameters]
        values = dict(zip(names, np.moveaxis(coefficients, -1, 0), strict=True))
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


def pile(parts: Sequence[Any]) -> Floats:
    """Numbers or arrays of one shape, (...), along a new last axis, (..., k)."""
    return np.stack(np.broadcast_arrays(*(np.asarray(part, np.float64) for part in parts)), axis=-1)
