"""The numbers that fields depend on, one set per scan."""

from __future__ import annotations

import math

import msgspec

from app.core.errors import WrongUse
from app.core.footprint import check_beam
from app.core.ghosts import THRESHOLD
from app.core.incidence import ESTIMATORS, RADIUS, Estimator
from app.core.phase import get_model
from app.core.phase.angular import AngularModel
from app.core.phase.formula_model import FormulaDefinition, make_formula_model
from app.core.radiometry.drift import check_power
from app.core.radiometry.profile import Profile
from app.core.synthetic_footprint import check_diameter
from app.model.corrections import Correction

LARGEST_RADIUS = 0.5
MOST_SIGMAS = 100.0


class Curve(msgspec.Struct, frozen=True):
    """An angular curve I(ω) in use: a model of `app.core.phase`, or a formula, with its values.

    Attributes
    ----------
    model : str
    values : dict of str to float
        Only those that are determined.
    channel : str
    origin : str
        Where it comes from in words, e.g. "fit of Leaf 3".
    within : (low, high)
        Radians between which intensity may be turned into an angle.
    formula : FormulaDefinition or None
        Of a model that is the user's own, so that a session opens where it is not known.
    """

    model: str
    values: dict[str, float]
    channel: str
    origin: str = ""
    within: tuple[float, float] = (0.0, math.pi / 2)
    formula: FormulaDefinition | None = None

    @property
    def angular_model(self) -> AngularModel:
        """The model of the curve.

        Raises
        ------
        WrongUse, MissingChannel
            There is none of that name, or the formula is none.
        """
        return get_model(self.model) if self.formula is None else make_formula_model(self.formula)


class Beam(msgspec.Struct, frozen=True):
    """A beam as it leaves the scanner: how large, and how fast it widens.

    Attributes
    ----------
    radius : float
        At the aperture, metres: half of the exit diameter.
    half_divergence : float
        Half of the full divergence, radians.
    origin : str
        Where it comes from in words, e.g. "instrument ls880" or "typed in".
    """

    radius: float
    half_divergence: float
    origin: str = ""

    def __post_init__(self) -> None:
        check_beam(self.radius, self.half_divergence)
        # Numbers of numpy pass for floats everywhere but in a session.
        for name in ("radius", "half_divergence"):
            msgspec.structs.force_setattr(self, name, float(getattr(self, name)))


class ScanPower(msgspec.Struct, frozen=True):
    """Laser power of one scan in one calibrated channel.

    Attributes
    ----------
    channel : str
        Name of the calibrated channel, e.g. ``reflectance_785``.
    value : float
        Share of the power at which the profile was made.
    sigma : float
    origin : str
        Where it comes from in words, e.g. "panel of 50 % in Leaf 3".
    pull : tuple of float
        Derivative of the power by the parameters of the channel's chain, where it was measured
        with the profile in use: panel and target then share errors. Empty: measured otherwise.
    """

    channel: str
    value: float = 1.0
    sigma: float = 0.0
    origin: str = ""
    pull: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        check_power(self.value)
        if not 0.0 <= self.sigma < math.inf:
            raise WrongUse(f"The σ of a laser power must be a number from 0 on, not {self.sigma}.")


class Formula(msgspec.Struct, frozen=True):
    """A user's own index: a name and the text of a whitelisted formula."""

    name: str
    text: str


class Parameters(msgspec.Struct, frozen=True):
    """Parameters of the fields of one scan.

    Attributes
    ----------
    radius : float
        Neighbours of a point lie within this distance, metres.
    plane_gate : float
        Distance to a leaf's plane beyond which a point counts as off it, metres.
    ghost_threshold : float
        Score from which on a point counts as a ghost: above 0, at most 1.
    channel : str or None
        Channel that fits and angles from intensity use; None is the first one.
    curve : Curve or None
        Angular curve that turns intensity into an angle.
    formulas : tuple of Formula
    estimator : {'adaptive', 'robust', 'window', 'ball'}
        How the local plane at a point is found; see `app.core.incidence`.
    beam : Beam or None
        Beam of the scanner, for its footprint; None is unknown.
    profile : Profile or None
        Calibration that turns channels into reflectance.
    powers : tuple of ScanPower
        Laser power of this scan, per calibrated channel; where none is said, it is 1.
    partial_hits : bool
        Give a reflectance also to points that the beam hits in part.
    waveform_threshold : float
        Standard deviations of the noise above which a sample belongs to a return.
    corrections : tuple of Correction
        What is made of channels for the angle of incidence; see `app.core.workflows`.
    synthetic_footprint : float or None
        Diameter over which channels are averaged, metres; None does not.
    """

    radius: float = RADIUS
    plane_gate: float = 0.005
    ghost_threshold: float = THRESHOLD
    channel: str | None = None
    curve: Curve | None = None
    formulas: tuple[Formula, ...] = ()
    estimator: Estimator = "adaptive"
    beam: Beam | None = None
    profile: Profile | None = None
    powers: tuple[ScanPower, ...] = ()
    partial_hits: bool = False
    waveform_threshold: float = 5.0
    corrections: tuple[Correction, ...] = ()
    synthetic_footprint: float | None = None

    @property
    def radiometry(self) -> tuple[object, ...]:
        """What calibrated and corrected channels depend on, beside the channels of the file."""
        return (
            self.profile,
            self.powers,
            self.partial_hits,
            self.beam,
            self.waveform_threshold,
            self.corrections,
        )

    def __post_init__(self) -> None:
        if self.estimator not in ESTIMATORS:
            raise WrongUse(
                f"There is no estimator {self.estimator!r}.",
                f"Estimators: {', '.join(ESTIMATORS)}.",
            )
        _check_positive("The neighbour radius", self.radius)
        if self.radius > LARGEST_RADIUS:
            raise WrongUse(
                f"A neighbour radius of {self.radius:g} m is larger than any leaf.",
                f"Give metres, at most {LARGEST_RADIUS:g}; the usual 4 mm are 0.004.",
            )
        _check_positive("The plane gate", self.plane_gate)
        if not 0.0 < self.ghost_threshold <= 1.0:
            raise WrongUse(
                f"A ghost threshold lies above 0 and up to 1, not at {self.ghost_threshold:g}.",
                "A point is a ghost if its score is at least the threshold; 0 would call all so.",
            )
        if self.synthetic_footprint is not None:
            check_diameter(self.synthetic_footprint)
        if not 0.0 < self.waveform_threshold <= MOST_SIGMAS:
            raise WrongUse(
                f"The threshold of a waveform lies above 0 and up to {MOST_SIGMAS:g} σ of its "
                f"noise, not at {self.waveform_threshold:g}."
            )


def _check_positive(what: str, metres: float) -> None:
    if not (math.isfinite(metres) and metres > 0.0):
        raise WrongUse(f"{what} must be a positive length in metres, not {metres}.")
