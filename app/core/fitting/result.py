"""What a fit gives: parameters with errors, how good it is, and what to be warned of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.fitting.intervals import LEVEL, SHOWN, Kind, find_quantile, span
from app.core.phase import PhaseModel, get_model
from app.core.phase.angular import RIGHT_ANGLE
from app.core.phase.formula_model import FormulaDefinition, FormulaModel, make_formula_model

FitKind = Literal["points", "bins", "edge", "huber", "tukey", "trust region"]


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
    fixed : bool
        It was not fitted.
    """

    value: float | None
    sd: float | None
    unit: str
    at_bound: bool = False
    fixed: bool = False


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
    covariance : dict of str to dict of str to float
        Of the parameters that have a standard deviation; empty in results of old sessions.
    kind : str
        What was fitted to what: see `FitKind`.
    tau : float or None
        Quantile of an edge: the share of pairs below the curve.
    scale : float or None
        Standard deviation that a robust fit took a pair's to be, from the median of residuals.
    formula : FormulaDefinition or None
        Of a model that is not in the registry.
    """

    model: str
    n: int
    parameters: dict[str, Estimate]
    rss: float
    rmse: float
    r2: float | None
    angle_range: tuple[float, float]
    warnings: tuple[str, ...] = ()
    covariance: dict[str, dict[str, float]] = field(default_factory=dict)
    kind: FitKind = "points"
    tau: float | None = None
    scale: float | None = None
    formula: FormulaDefinition | None = None

    @property
    def values(self) -> dict[str, float]:
        """Parameters by name; NaN for an undetermined one."""
        return {
            name: np.nan if estimate.value is None else estimate.value
            for name, estimate in self.parameters.items()
        }

    @property
    def spare(self) -> int:
        """Degrees of freedom: pairs less fitted parameters."""
        return self.n - sum(not estimate.fixed for estimate in self.parameters.values())

    def interval(
        self, name: str, level: float = LEVEL, kind: Kind = SHOWN
    ) -> tuple[float, float] | None:
        """Interval of a parameter from its standard deviation and Student's t; None without one.

        Parameters
        ----------
        name : str
        level : float
        kind : str
            See `app.core.fitting.intervals.span`.
        """
        estimate = self.parameters[name]
        if estimate.value is None or estimate.sd is None:
            return None
        p = next(p for p in self.angular_model.parameters if p.name == name)
        low, high = span(p, estimate.value, estimate.sd, find_quantile(level, self.spare), kind)
        return float(low), float(high)

    @property
    def aic(self) -> float | None:
        """Akaike's criterion, n·ln(rss/n) + 2k with k counting σ; None for a perfect fit."""
        k = self.n - self.spare + 1
        return self.n * float(np.log(self.rss / self.n)) + 2 * k if self.rss > 0 else None

    @property
    def aicc(self) -> float | None:
        """AIC for few pairs; None where there are too few even for it."""
        k = self.n - self.spare + 1
        room = self.n - k - 1
        return self.aic + 2 * k * (k + 1) / room if self.aic is not None and room > 0 else None

    @property
    def bic(self) -> float | None:
        """The Bayesian criterion of Schwarz."""
        k = self.n - self.spare + 1
        return None if self.aic is None else self.aic + k * (float(np.log(self.n)) - 2)

    @property
    def valid_range(self) -> tuple[float, float]:
        """Angles, radians, on which the curve may be inverted if it is monotone there."""
        return (0.0, RIGHT_ANGLE) if self.angular_model.extrapolates else self.angle_range

    def evaluate(self, angle: Floats) -> Floats:
        """The fitted curve at `angle`, radians; array of the same shape."""
        return self.angular_model.evaluate(angle, self.values)

    def slope(self, angle: Floats) -> Floats:
        """Its derivative per radian: σ_ω = σ_I / |slope|."""
        return self.angular_model.slope(angle, self.values)

    def inverse(self, value: Floats) -> Floats:
        """Angle, radians, at which the curve has `value`; array of the same shape.

        NaN where the curve does not reach the value on its monotone interval within
        `valid_range`: the fitted angles only, for models that are mere interpolants.
        """
        return self.angular_model.inverse(value, self.values, self.valid_range)

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
            wanted = {p.name for p in result.angular_model.parameters}
        except (msgspec.ValidationError, WrongUse, MissingChannel) as error:
            raise BadInput(f"A stored fit cannot be read: {error}") from error
        if set(result.parameters) != wanted:
            raise BadInput(f"A stored fit of {result.model} has other parameters than the model.")
        return result

    @property
    def angular_model(self) -> PhaseModel | FormulaModel:
        """The model of the curve: one of the registry, or the user's formula."""
        return get_model(self.model) if self.formula is None else make_formula_model(self.formula)
