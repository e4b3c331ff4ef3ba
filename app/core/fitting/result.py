"""What a fit gives: parameters with errors, how good it is, and what to be warned of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, WrongUse
from app.core.phase import PhaseModel, get_model
from app.core.phase.model import RIGHT_ANGLE


@dataclass(frozen=True, slots=True)
class Estimate:
    """One fitted parameter.

    Attributes
    ----------
    value : float or None
        None when the data leave it undetermined; the result's warnings say why.
    sd : float or None
        Standard deviation; None when there is none (at a bound, fixed, undetermined).
    unit : str
        ``1`` for a pure number, ``value`` for the unit of the data, ``deg`` for angles.
    at_bound : bool
    """

    value: float | None
    sd: float | None
    unit: str
    at_bound: bool = False


@dataclass(frozen=True, slots=True)
class FitResult:
    """One model fitted to one set of pairs (angle, value).

    Attributes
    ----------
    model : str
        Name in the registry.
    n : int
        Pairs used.
    parameters : dict of str to Estimate
    rss : float
        (Weighted) sum of squared residuals.
    rmse : float
        Root of the (weighted) mean square of the residuals.
    r2 : float or None
        1 − rss / total sum of squares; None when all values are equal.
    angle_range : (float, float)
        Smallest and largest angle used, radians.
    warnings : tuple of str
    """

    model: str
    n: int
    parameters: dict[str, Estimate]
    rss: float
    rmse: float
    r2: float | None
    angle_range: tuple[float, float]
    warnings: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Parameters by name; NaN for an undetermined one."""
        return {
            name: np.nan if estimate.value is None else estimate.value
            for name, estimate in self.parameters.items()
        }

    @property
    def valid_range(self) -> tuple[float, float]:
        """Angles, radians, on which the curve may be inverted if it is monotone there."""
        return (0.0, RIGHT_ANGLE) if self._model.extrapolates else self.angle_range

    def evaluate(self, angle: Floats) -> Floats:
        """The fitted curve at `angle`, radians; array of the same shape."""
        return self._model.evaluate(angle, self.values)

    def slope(self, angle: Floats) -> Floats:
        """Its derivative per radian: σ_ω = σ_I / |slope|."""
        return self._model.slope(angle, self.values)

    def inverse(self, value: Floats) -> Floats:
        """Angle, radians, at which the curve has `value`; array of the same shape.

        NaN where the curve does not reach the value on its monotone interval within
        `valid_range`: the fitted angles only, for models that are mere interpolants.
        """
        return self._model.inverse(value, self.values, self.valid_range)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, texts, lists and dictionaries, as JSON has them."""
        import msgspec

        plain: dict[str, Any] = msgspec.to_builtins(self)
        return plain | {
            "angle_range": list(self.angle_range),
            "warnings": list(self.warnings),
        }

    @classmethod
    def from_dict(cls, plain: Mapping[str, Any]) -> FitResult:
        """The result that `as_dict` wrote.

        Raises
        ------
        BadInput
            Something is missing, of another type, or of a model that does not exist.
        """
        import msgspec

        try:
            result = msgspec.convert(dict(plain), cls, strict=True)
            wanted = {p.name for p in get_model(result.model).parameters}
        except (msgspec.ValidationError, WrongUse) as error:
            raise BadInput(f"A stored fit cannot be read: {error}") from error
        if set(result.parameters) != wanted:
            raise BadInput(f"A stored fit of {result.model} has other parameters than the model.")
        return result

    @property
    def _model(self) -> PhaseModel:
        return get_model(self.model)
