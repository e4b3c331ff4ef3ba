"""How far a leaf's intensity lies off its curve: a shift of DN, or a factor of reflectance.

A logarithmic amplifier turns a factor into a shift (Balduzzi 2011, equation 3): the +50 DN that
the paper sees between its stage and the tree are a factor of 10^(50 / a0) in reflectance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse

OffsetKind = Literal["added", "factor"]
Scale = Literal["linear", "log"]
LN10 = float(np.log(10.0))


@dataclass(frozen=True, slots=True)
class Offset:
    """What turns the curve's intensity into that of this scan.

    Attributes
    ----------
    kind : {'added', 'factor'}
        'added' to numbers of a logarithmic scale (DN, dB), a 'factor' of linear ones.
    value : float
        DN or dB, or a pure number.
    sigma : float
        Standard deviation of `value`.
    """

    kind: OffsetKind
    value: float
    sigma: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite(self.value) or (self.kind == "factor" and self.value <= 0.0):
            raise WrongUse(
                f"{self.value:g} is no offset.",
                "Give a finite number of DN for a logarithmic scale, a factor above 0 for a "
                "linear one.",
            )
        if not 0.0 <= self.sigma < np.inf:
            raise WrongUse(f"The σ of an offset must be a number from 0 on, not {self.sigma:g}.")

    def remove(self, intensity: Floats) -> Floats:
        """What the curve knows of an intensity of this scan."""
        return intensity - self.value if self.kind == "added" else intensity / self.value

    def apply(self, intensity: Floats) -> Floats:
        """What this scan makes of an intensity of the curve."""
        return intensity + self.value if self.kind == "added" else intensity * self.value

    def sigma_of(self, intensity: Floats) -> Floats:
        """Error that it brings to intensities that are those of the curve."""
        if self.kind == "added":
            return np.full(np.shape(intensity), self.sigma)
        return np.abs(intensity) * (self.sigma / self.value)


def no_offset(scale: Scale, sigma: float = 0.0) -> Offset:
    """The offset that changes nothing, with a σ."""
    return Offset("added", 0.0, sigma) if scale == "log" else Offset("factor", 1.0, sigma)


def find_factor(shift: float, per_decade: float) -> float:
    """The factor of reflectance that a shift of a logarithmic instrument is.

    Parameters
    ----------
    shift : float
        DN or dB.
    per_decade : float
        DN or dB per factor of ten, a0 (10 for dB).
    """
    _check_decade(per_decade)
    return float(10.0 ** (shift / per_decade))


def scatter_of(relative: float, scale: Scale, per_decade: float | None) -> Offset:
    """Reflectance that scatters from leaf to leaf by a share of itself, as an offset.

    Raises
    ------
    WrongUse
        A logarithmic scale whose DN per decade nobody told.
    """
    if scale == "linear":
        return Offset("factor", 1.0, relative)
    if per_decade is None:
        raise WrongUse(
            "Reflectance that scatters is a shift on a logarithmic scale, and nobody told its DN "
            "per decade.",
            "Give the instrument, or the DN per factor of ten.",
        )
    _check_decade(per_decade)
    return Offset("added", 0.0, relative * per_decade / LN10)


def _check_decade(per_decade: float) -> None:
    if not 0.0 < per_decade < np.inf:
        raise WrongUse(f"A logarithmic scale has DN per decade above 0, not {per_decade:g}.")
