"""An angular curve that is known: its values, its slope, how sure it is, where it may be read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput, WrongUse
from app.core.fitting import FitResult
from app.core.phase.angular import RIGHT_ANGLE, AngularModel
from app.core.phase.inversion import find_monotone_interval, invert_monotone
from app.core.wrinkling.offset import LN10, Scale

SAMPLES = 721
Function = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class KnownCurve:
    """I(ω) that intensity is read backwards on. Angles are radians.

    Attributes
    ----------
    evaluate, slope : callable
        I(ω) and dI/dω.
    within : (float, float)
        Angles at which the curve is known: those measured, or all.
    scale : {'linear', 'log'}
        Of its intensities: an offset is a factor, or is added.
    per_decade : float or None
        DN or dB per factor of ten of a logarithmic scale, where it is known.
    origin : str
        Where it comes from, in words.
    jacobian : callable or None
        ω (n,) → dI/dparameter, (n, p).
    covariance : (p, p) array
    """

    evaluate: Function
    slope: Function
    within: tuple[float, float] = (0.0, RIGHT_ANGLE)
    scale: Scale = "linear"
    per_decade: float | None = None
    origin: str = ""
    jacobian: Function | None = None
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    @cached_property
    def monotone(self) -> tuple[float, float]:
        """Widest part on which it only falls or only rises; raises `BadInput` for a flat one."""
        found = find_monotone_interval(self.slope, *self.within)
        if found is None:
            raise BadInput(
                "The curve is flat: intensity says nothing about the angle.",
                "Measure more angles, or take the curve of a species.",
            )
        return found

    @cached_property
    def span(self) -> tuple[float, float]:
        """Lowest and highest intensity that has an angle."""
        ends = self.evaluate(np.array(self.monotone))
        return float(ends.min()), float(ends.max())

    @property
    def falls(self) -> bool:
        """Whether intensity falls with the angle, as that of leaves does."""
        low, high = self.evaluate(np.array(self.monotone))
        return bool(low > high)

    def invert(self, intensity: Floats) -> Floats:
        """Angle of each intensity; NaN where the curve has none."""
        return invert_monotone(
            self.evaluate, self.slope, np.asarray(intensity, float), self.monotone
        )

    def is_ambiguous(self, intensity: Floats) -> Bools:
        """Intensities that the curve has outside its monotone part as well."""
        found = np.zeros(np.shape(intensity), bool)
        (start, stop), (low, high) = self.within, self.monotone
        for begin, end in ((start, low), (high, stop)):
            if end - begin > (stop - start) / SAMPLES:
                # Angles up to the turn itself: the turn's own intensity is no second one.
                angle = np.linspace(begin, end, SAMPLES)
                angle = angle[:-1] if end == low else angle[1:]
                part = self.evaluate(angle)
                part = part[np.isfinite(part)]
                if len(part):
                    found |= (intensity >= part.min()) & (intensity <= part.max())
        return found

    def sigma(self, angle: Floats) -> Floats:
        """Error of I(ω) from the errors of the curve's parameters."""
        known = np.isfinite(angle)
        found = np.full(np.shape(angle), np.nan)
        found[known] = 0.0
        if self.jacobian is not None and len(self.covariance) and known.any():
            pull = self.jacobian(angle[known])
            found[known] = np.sqrt(
                np.maximum(np.einsum("ni,ij,nj->n", pull, self.covariance, pull), 0.0)
            )
        return found


def curve_of_fit(result: FitResult, scale: Scale, origin: str = "") -> KnownCurve:
    """The curve of a fit, with the errors of its parameters."""
    names = [name for name in result.covariance]
    table = np.array([[result.covariance[a][b] for b in names] for a in names])
    values = result.values
    model = result.angular_model
    low, high = result.valid_range
    return KnownCurve(
        result.evaluate,
        result.slope,
        (low, min(high, model.reach(values))),
        scale,
        None,
        origin,
        (lambda angle: model.jacobian(angle, values, names)) if names else None,
        table.reshape(len(names), len(names)),
    )


def curve_of_model(
    model: AngularModel,
    values: Mapping[str, float],
    within: tuple[float, float] = (0.0, RIGHT_ANGLE),
    origin: str = "",
    per_decade: float | None = None,
    scale: Scale = "linear",
) -> KnownCurve:
    """A curve from a model and its values, in linear intensity, or as a logarithmic instrument
    gives it.

    Parameters
    ----------
    per_decade : float or None
        DN or dB per factor of ten: a0·log10 of the model. None: the model as it is, whose
        intensities `scale` tells.
    """
    stop = min(within[1], model.reach(values))
    if per_decade is None:
        return KnownCurve(
            lambda angle: model.evaluate(angle, values), lambda angle: model.slope(angle, values),
            (within[0], stop), scale, None, origin,
        )  # fmt: skip
    if not 0.0 < per_decade < np.inf:
        raise WrongUse(f"A logarithmic scale has DN per decade above 0, not {per_decade:g}.")

    def evaluate(angle: Floats) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(per_decade * np.log10(model.evaluate(angle, values)), np.float64)

    def slope(angle: Floats) -> Floats:
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = model.slope(angle, values) / model.evaluate(angle, values)
            return np.asarray(per_decade / LN10 * relative, np.float64)

    # At 90° the logarithm is infinite.
    return KnownCurve(
        evaluate, slope, (within[0], min(stop, RIGHT_ANGLE - 1e-3)), "log", per_decade, origin
    )
