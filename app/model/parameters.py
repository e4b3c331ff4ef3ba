"""The numbers that fields depend on, one set per scan."""

from __future__ import annotations

import math

import msgspec

from app.core.errors import WrongUse
from app.core.footprint import check_beam
from app.core.ghosts import THRESHOLD
from app.core.incidence import ESTIMATORS, RADIUS, Estimator

LARGEST_RADIUS = 0.5


class Curve(msgspec.Struct, frozen=True):
    """An angular curve I(ω) in use: a model of `app.core.phase` with its values.

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
    """

    model: str
    values: dict[str, float]
    channel: str
    origin: str = ""
    within: tuple[float, float] = (0.0, math.pi / 2)


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
        Score from which a point counts as a ghost, 0 to 1.
    channel : str or None
        Channel that fits and angles from intensity use; None is the first one.
    curve : Curve or None
        Angular curve that turns intensity into an angle.
    formulas : tuple of Formula
    estimator : {'adaptive', 'robust', 'window', 'ball'}
        How the local plane at a point is found; see `app.core.incidence`.
    beam : Beam or None
        Beam of the scanner, for its footprint; None is unknown.
    """

    radius: float = RADIUS
    plane_gate: float = 0.005
    ghost_threshold: float = THRESHOLD
    channel: str | None = None
    curve: Curve | None = None
    formulas: tuple[Formula, ...] = ()
    estimator: Estimator = "adaptive"
    beam: Beam | None = None

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
        if not 0.0 <= self.ghost_threshold <= 1.0:
            raise WrongUse(f"A ghost threshold lies in 0 to 1, not at {self.ghost_threshold}.")


def _check_positive(what: str, metres: float) -> None:
    if not (math.isfinite(metres) and metres > 0.0):
        raise WrongUse(f"{what} must be a positive length in metres, not {metres}.")
