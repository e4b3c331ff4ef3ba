"""A profile: how one instrument turns light into numbers, channel by channel, and how sure."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry import chain as chains
from app.core.radiometry.chain import AnyStep

Origin = Literal["yours", "published"]
Matrix = tuple[tuple[float, ...], ...]
MOST_MARGIN = 0.1
"""Metres by which the limits of a channel may lie beyond where its steps are known: ranges have
noise, and a panel at the border of the calibration still counts."""


class Noise(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Noise of one number: σ² = constant² + (share · DN)² + (light · echo)².

    Attributes
    ----------
    constant : float
        DN.
    share : float
        Of the DN itself.
    light : float
        Of the light that comes back, before the amplifier: what it does to the number follows
        from the slope of the response, steep below SALCA's knee and shallow above it.
    """

    constant: float = 0.0
    share: float = 0.0
    light: float = 0.0

    def __post_init__(self) -> None:
        if not all(0.0 <= part < np.inf for part in (self.constant, self.share, self.light)):
            raise WrongUse("The noise of a channel must be a number from 0 on.")

    def sigma(self, number: Floats, echo: Floats | float = 0.0) -> Floats:
        """σ of numbers, (n,).

        Parameters
        ----------
        number : (n,) array
        echo : (n,) array
            Reflectance times the derivative of the number by it, DN.
        """
        own = np.hypot(self.constant, self.share * np.asarray(number))
        return np.asarray(np.hypot(own, self.light * np.asarray(echo)))


class Evidence(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What a calibration rests on, to be shown beside it.

    Attributes
    ----------
    rows, left_out : int
        Rows of the table that were used; saturated or dark ones that were not.
    panels : tuple of str
    rmse, bias : float
        Of the reflectance over the rows used.
    left_out_rmse : float or None
        The same, of each panel from a fit without it.
    table : str
        Name of the table or scans.
    """

    rows: int
    left_out: int
    panels: tuple[str, ...]
    rmse: float
    bias: float
    left_out_rmse: float | None = None
    table: str = ""


class ChannelCalibration(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """One channel of an instrument, from light to number.

    Attributes
    ----------
    channel : str
        Name of the channel (or field) in scans of the instrument.
    wavelength_nm : float or None
    steps : tuple
        From light to number; see `app.core.radiometry.chain`.
    dark, saturated : float or None
        Numbers at and below, at and above which nothing is told.
    nearest, farthest : float or None
        Ranges that were calibrated, metres.
    reflectances : (low, high) or None
        Of the panels that were used.
    noise : Noise or None
        None: unknown, and so is the σ of every reflectance.
    range_sigma : float
        σ of a range, metres.
    fit_covariance, panel_covariance : matrix
        Of the free parameters in their order, from the noise of the table and from the
        uncertainty of the panels; empty where nothing is known, and then σ is not known either.
    evidence : Evidence or None
    """

    channel: str
    steps: tuple[AnyStep, ...]
    wavelength_nm: float | None = None
    dark: float | None = None
    saturated: float | None = None
    nearest: float | None = None
    farthest: float | None = None
    reflectances: tuple[float, float] | None = None
    noise: Noise | None = None
    range_sigma: float = 0.0
    fit_covariance: Matrix = ()
    panel_covariance: Matrix = ()
    evidence: Evidence | None = None

    def __post_init__(self) -> None:
        if not self.steps:
            raise WrongUse(f"The calibration of {self.channel} has no step.")
        if self.wavelength_nm is not None and not 0.0 < self.wavelength_nm < np.inf:
            raise WrongUse(f"The wavelength of {self.channel} must be a number of nanometres.")
        if not 0.0 <= self.range_sigma < np.inf:
            raise WrongUse("The σ of a range must be a number of metres from 0 on.")
        for matrix in (self.fit_covariance, self.panel_covariance):
            self._check_matrix(matrix)
        self._check_limits()

    def _check_limits(self) -> None:
        near, far = chains.known_ranges(self.steps)
        beyond = max(
            near - (near if self.nearest is None else self.nearest),
            0.0 if self.farthest is None else self.farthest - far,
        )
        if not beyond <= MOST_MARGIN * (1.0 + 1e-9):
            raise WrongUse(
                f"The limits of {self.channel} lie {beyond:g} m beyond the {near:g} to {far:g} m "
                f"that its range effect is known for; {MOST_MARGIN:g} m is allowed.",
                "Correct nearest and farthest, or calibrate at these ranges.",
            )

    def _check_matrix(self, matrix: Matrix) -> None:
        size = len(chains.names(self.steps))
        if matrix and not (len(matrix) == size and all(len(row) == size for row in matrix)):
            raise WrongUse(
                f"A covariance of {self.channel} is not {size} × {size}, "
                f"for its {size} free parameters."
            )

    @property
    def name(self) -> str:
        """Name of the field that it gives: ``reflectance_785``, or ``corrected_785``.

        Whole nanometres, as channels are named everywhere.
        """
        kind = "reflectance" if chains.has_response(self.steps) else "corrected"
        if self.wavelength_nm is not None:
            return f"{kind}_{self.wavelength_nm:.0f}"
        # Of RIEGL's "Reflectance", in dB, comes the same on a linear scale.
        return f"{kind}_{'linear' if self.channel.casefold() == kind else self.channel}"

    @property
    def kind(self) -> Literal["reflectance", "DN"]:
        """What its numbers are: reflectance, or DN as at the reference range."""
        return "reflectance" if chains.has_response(self.steps) else "DN"

    @property
    def needs_range(self) -> bool:
        """Whether distances count: a step depends on them, or they must lie within limits."""
        limited = self.nearest is not None or self.farthest is not None
        return limited or chains.needs_range(self.steps)

    def holds(self, distance: Floats) -> Bools:
        """Whether distances lie within the limits, (n,); NaN does not, if there are limits."""
        if not self.needs_range:
            return np.ones(np.shape(distance), bool)
        low, high = self._limits
        return np.asarray((distance >= low) & (distance <= high))

    def hold(self, distance: Floats) -> Floats:
        """Distances at which the steps are asked, (n,).

        Within the limits, but a little beyond where a step is known (the margin that somebody
        granted), the effect of range is taken as at its end: nothing is extrapolated.
        """
        low, high = chains.known_ranges(self.steps)
        return np.where(self.holds(distance), np.clip(distance, low, high), distance)

    @property
    def _limits(self) -> tuple[float, float]:
        known = chains.known_ranges(self.steps)
        low = known[0] if self.nearest is None else self.nearest
        high = known[1] if self.farthest is None else self.farthest
        return low, high

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free parameters, in the order of the covariances."""
        return chains.names(self.steps)

    def covariance(self, which: Literal["fit", "panel"]) -> Floats:
        """A covariance as (k, k) array; NaN where nothing is known."""
        matrix = self.fit_covariance if which == "fit" else self.panel_covariance
        shape = (len(self.free), len(self.free))
        return np.array(matrix, float).reshape(shape) if matrix else np.full(shape, np.nan)


class Profile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The calibration of an instrument.

    Attributes
    ----------
    name : str
    instrument : str
        Short name such as ``salca``; empty when unknown.
    origin : {'yours', 'published'}
        Published numbers are those of another copy of the instrument.
    channels : tuple of ChannelCalibration
    notes : tuple of str
    """

    name: str
    channels: tuple[ChannelCalibration, ...]
    instrument: str = ""
    origin: Origin = "yours"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.channels:
            raise BadInput(f"The profile {self.name} calibrates no channel.")
        names = [channel.name for channel in self.channels]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise BadInput(f"The profile {self.name} gives {', '.join(twice)} more than once.")
