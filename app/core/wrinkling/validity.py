"""Angles from intensity with their whole error, their interval, and why one is not valid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.errors import BadInput, WrongUse
from app.core.intensity_angle import TRUSTED_TO, Doubt
from app.core.phase.angular import RIGHT_ANGLE
from app.core.wrinkling.curve import KnownCurve
from app.core.wrinkling.offset import Offset, no_offset

PARTS = ("noise", "curve", "reflectance", "offset")
"""What the error of an angle is made of."""
LARGEST_SIGMA = float(np.deg2rad(15.0))
WORDS: Mapping[Doubt, str] = {
    Doubt.GHOST: "ghosts",
    Doubt.SATURATED: "saturated",
    Doubt.PARTIAL: "beam only in part on the leaf",
    Doubt.MISSING: "no intensity",
    Doubt.OUTSIDE: "outside the curve",
    Doubt.AMBIGUOUS: "two angles have this intensity",
    Doubt.BEYOND: "steeper than the limit",
    Doubt.FLAT: "curve too flat for the error",
}
"""What is said of a point; of several causes, the first in this order."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Up to where an angle from intensity is valid; radians.

    Attributes
    ----------
    steepest : float
        Beyond it intensity says little (Balduzzi 2011: 60°).
    largest_sigma : float
        Of the errors that differ from point to point and those that points share.
    """

    steepest: float = TRUSTED_TO
    largest_sigma: float = LARGEST_SIGMA

    def __post_init__(self) -> None:
        if not 0.0 < self.steepest <= RIGHT_ANGLE:
            raise WrongUse(
                f"The steepest valid angle lies above 0° and up to 90°, not at "
                f"{np.rad2deg(self.steepest):g}°."
            )
        if not self.largest_sigma > 0.0:
            raise WrongUse("The largest valid σ of an angle is above 0°.")


USUAL = Limits()


@dataclass(frozen=True, slots=True, eq=False)
class PointAngles:
    """Angles of points, radians.

    Attributes
    ----------
    omega : (n,)
        NaN where the intensity has no angle. Doubtful ones keep theirs.
    sigma : (n,)
        All parts together; infinite where the curve is level.
    parts : dict of str to (n,)
        See `PARTS`. 'noise' differs from point to point, the others are shared by a leaf.
    low, high : (n,)
        68 % interval, read on the curve itself and not on its tangent: it ends at face-on, and
        is known for points brighter than the curve as well.
    doubt : (n,) uint8
        Sum of `Doubt` flags; 0 is valid.
    """

    omega: Floats
    sigma: Floats
    parts: Mapping[str, Floats]
    low: Floats
    high: Floats
    doubt: AnyArray

    @property
    def valid(self) -> Bools:
        """Points without a doubt."""
        found: Bools = self.doubt == 0
        return found


def invert_points(
    intensity: Floats,
    noise: Floats | float,
    curve: KnownCurve,
    offset: Offset | None = None,
    scatter: Offset | None = None,
    limits: Limits = USUAL,
    saturated: Bools | None = None,
    partial: Bools | None = None,
    ghost: Bools | None = None,
) -> PointAngles:
    """Angle of each point from its intensity.

    σ_ω² is the sum of the squares of four errors of the intensity, each over |dI/dω|: noise of
    the channel, the curve's parameters, the leaf's reflectance, the offset.

    Parameters
    ----------
    intensity : (n,) array
        Corrected for range; not for angle.
    noise : float or (n,) array
        Standard deviation of `intensity`.
    curve : KnownCurve
    offset : Offset or None
        What the scan adds to the curve; None: nothing, for sure.
    scatter : Offset or None
        Reflectance of a leaf about the curve's; see `offset.scatter_of`.
    limits : Limits
    saturated, partial, ghost : (n,) bools or None
        Points whose channel is at its end; that the beam hits in part; that are on no surface.

    Raises
    ------
    BadInput
        The curve is flat, or the noise is negative.
    """
    given = np.asarray(intensity, np.float64).ravel()
    level = np.broadcast_to(np.asarray(noise, np.float64), given.shape)
    if (level < 0.0).any():
        raise BadInput("The noise of an intensity cannot be negative.")
    offset = offset or no_offset(curve.scale)
    with np.errstate(over="ignore", invalid="ignore"):
        read = offset.remove(given)
    read = np.where(np.isfinite(read), read, np.nan)
    omega = curve.invert(read)
    errors = _find_errors(read, omega, level, curve, offset, scatter or no_offset(curve.scale))
    parts = _over_slope(errors, omega, curve)
    sigma = np.sqrt(sum(part**2 for part in parts.values()))
    total = np.sqrt(sum(error**2 for error in errors.values()))
    low, high = _find_interval(read, total, curve)
    doubt = _judge(read, omega, sigma, curve, limits)
    for mask, flag in (
        (saturated, Doubt.SATURATED), (partial, Doubt.PARTIAL), (ghost, Doubt.GHOST)
    ):  # fmt: skip
        doubt = doubt | _flag(mask, flag, given)
    return PointAngles(omega, sigma, parts, low, high, doubt.astype(np.uint8))


def _find_errors(
    read: Floats, omega: Floats, noise: Floats, curve: KnownCurve, offset: Offset, scatter: Offset
) -> dict[str, Floats]:
    """Errors of each intensity by their cause; off the curve those at its nearest end."""
    size = np.where(np.isnan(omega), np.clip(read, *curve.span), read)
    nearest = np.where(np.isnan(omega) & ~np.isnan(read), curve.invert(size), omega)
    return {
        # Noise was measured in this scan's numbers: a factor changes it as well.
        "noise": noise / offset.value if offset.kind == "factor" else noise,
        "curve": curve.sigma(nearest),
        "reflectance": scatter.sigma_of(size),
        "offset": offset.sigma_of(size),
    }


def _flag(mask: Bools | None, doubt: Doubt, like: Floats) -> AnyArray:
    where = np.zeros(len(like), bool) if mask is None else np.asarray(mask, bool)
    return where * int(doubt)


def _over_slope(
    errors: Mapping[str, Floats], omega: Floats, curve: KnownCurve
) -> dict[str, Floats]:
    slope = np.full(len(omega), np.nan)
    known = np.isfinite(omega)
    slope[known] = np.abs(curve.slope(omega[known]))
    found = {}
    for name, error in errors.items():
        with np.errstate(divide="ignore", invalid="ignore"):
            angle = error / slope
        angle[known & (error == 0.0)] = 0.0  # no error is none, even where the curve is level
        found[name] = angle
    return found


def _find_interval(read: Floats, sigma: Floats, curve: KnownCurve) -> tuple[Floats, Floats]:
    """Angles of the intensities one σ brighter and one σ darker, held within the curve."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if curve.scale == "linear":
            # A share of itself: what was measured is (1 ± share) times what the curve has.
            share = np.minimum(sigma / np.abs(read), 1.0)
            dark, bright = read / (1.0 + share), read / (1.0 - share)
        else:
            dark, bright = read - sigma, read + sigma
    below, above = curve.span
    dark = np.where(dark > above, np.nan, np.clip(dark, below, above))
    bright = np.where(bright < below, np.nan, np.clip(bright, below, above))
    unknown = np.isnan(dark) | np.isnan(bright)
    first, second = curve.invert(bright), curve.invert(dark)
    low, high = (first, second) if curve.falls else (second, first)
    return np.where(unknown, np.nan, low), np.where(unknown, np.nan, high)


def _judge(
    read: Floats, omega: Floats, sigma: Floats, curve: KnownCurve, limits: Limits
) -> AnyArray:
    missing = np.isnan(read)
    outside = np.isnan(omega) & ~missing
    found = ~missing & ~outside
    with np.errstate(invalid="ignore"):
        found_doubt: AnyArray = (
            missing * int(Doubt.MISSING)
            | outside * int(Doubt.OUTSIDE)
            | (found & (omega > limits.steepest)) * int(Doubt.BEYOND)
            | (found & ~(sigma <= limits.largest_sigma)) * int(Doubt.FLAT)
            | (found & curve.is_ambiguous(read)) * int(Doubt.AMBIGUOUS)
        )
    return found_doubt


def name_reasons(doubt: AnyArray) -> dict[str, int]:
    """How many points have each cause as their first, in words; and how many are valid."""
    left = np.asarray(doubt).copy()
    counts = {"valid": int((left == 0).sum())}
    for flag, word in WORDS.items():
        mine = (left & int(flag)) != 0
        counts[word] = int(mine.sum())
        left[mine] = 0
    return counts
