"""What is asked for: where the curve comes from, what is added to it, what is valid."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from app.core.errors import WrongUse
from app.core.wrinkling.leaf import Choices

FitOffset = Literal["fit"]
SCATTER = 0.08
"""Reflectance of leaves of a species about their mean, as a share of it."""


@dataclass(frozen=True, slots=True)
class ScanCurve:
    """One curve is fitted to all leaves of the scan, and every leaf is levelled with its plane."""

    model: str | None = None


@dataclass(frozen=True, slots=True)
class OwnCurve:
    """The curve is fitted to each leaf's own points and their local planes."""

    model: str | None = None


@dataclass(frozen=True, slots=True)
class TableCurve:
    """The curve is fitted to a table of a goniometer: columns angle (degrees) and value."""

    path: Path
    model: str | None = None


@dataclass(frozen=True, slots=True)
class SpeciesSource:
    """The curve's shape is published for a species.

    Attributes
    ----------
    reflectance : float or None
        Of the species at ω = 0; None: the median of the scan's own leaves, by their planes.
    scatter : float
        Of leaves about it, a share.
    """

    species: str
    reflectance: float | None = None
    scatter: float = SCATTER

    def __post_init__(self) -> None:
        if not 0.0 <= self.scatter < 1.0:
            raise WrongUse(f"Reflectance scatters by a share of 0 to 1, not {self.scatter:g}.")
        if self.reflectance is not None and not 0.0 < self.reflectance < 100.0:
            raise WrongUse(f"A reflectance is a share above 0, not {self.reflectance:g}.")


@dataclass(frozen=True, slots=True)
class CurveInUse:
    """The curve that the scan's parameters hold, e.g. from the phase lab."""

    of_this_leaf: bool = False
    "Whether it is known to be the leaf's own, offset and all."
    scatter: float = SCATTER


Source = ScanCurve | OwnCurve | TableCurve | SpeciesSource | CurveInUse


@dataclass(frozen=True, slots=True)
class WrinkleRequest:
    """What is asked of a scan.

    Attributes
    ----------
    source : Source
    offset : 'fit', float or None
        'fit': each leaf's mean is set to its plane. A number: what the scan adds to the curve, DN
        or dB on a logarithmic scale, a factor on a linear one. None: nothing.
    channel : str or None
    instrument : str or None
        Preset whose amplifier and beam are meant, where the scan does not say.
    saturated : float or None
        Value from which a channel is at its end.
    choices : Choices
    """

    source: Source = field(default_factory=ScanCurve)
    offset: FitOffset | float | None = None
    channel: str | None = None
    instrument: str | None = None
    saturated: float | None = None
    choices: Choices = field(default_factory=Choices)
