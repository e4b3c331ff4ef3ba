"""Why a point counts as a ghost, or does not, in numbers that a person can check."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.footprint import BeamShape
from app.core.ghosts.correction import CLEAN
from app.core.ghosts.image import GhostImage, measure_beams
from app.core.ghosts.score import BEAM, THRESHOLD
from app.core.ghosts.surfaces import BeamSurfaces, find_surfaces, lay_ground, number_members
from app.core.progress import QUIET, Progress

ON_SURFACE = 0.006
"""Metres within which a point lies on a surface: the truth that scores are measured by."""
STEEP = float(np.tan(np.deg2rad(70.0)))


class Reason(IntEnum):
    """What a point is; classes of the field ghost_reason."""

    ON_SURFACE = 0
    BETWEEN = 1
    BESIDE = 2
    ALONE = 3
    STEEP = 4
    WEAK = 5


WORDS = {
    Reason.ON_SURFACE: "on a surface",
    Reason.BETWEEN: "between two surfaces",
    Reason.BESIDE: "beside a surface, in front of or behind all that is around",
    Reason.ALONE: "alone, no surface around",
    Reason.STEEP: "in a steep, lengthened part of a leaf",
    Reason.WEAK: "on a surface, but nothing goes on through it",
}


@dataclass(frozen=True, slots=True, eq=False)
class Reasons:
    """Evidence on some points, (k,) each; NaN where there is none.

    Attributes
    ----------
    reason : uint8
        Of `Reason`.
    offset : (k, 2) metres
        From the point to the nearest surface in range and to the next; positive lies behind it.
    member : (k, 2) int64
        A point of each of these surfaces, -1 without.
    light : fraction, or None
        Light over the mean of the nearest surface around, for light told as a logarithm to base e.
    border : beam diameters
        To the middle between both surfaces; negative: on the far side, nearer to the second.
    incidence : radians
        Of the nearest surface.
    """

    reason: AnyArray
    offset: Floats
    member: Ints
    light: Floats | None
    border: Floats
    incidence: Floats


def explain_points(
    image: GhostImage, points: Ints, score: Floats, *, threshold: float = THRESHOLD,
    beam: BeamShape | None = None, light: Floats | None = None, progress: Progress = QUIET,
) -> Reasons:  # fmt: skip
    """Say why points are ghosts or not.

    Parameters
    ----------
    image : GhostImage
    points : (k,) numbers
    score : (n,) 0 to 1
        Of all points.
    threshold : float
        Score from which on a point is a ghost, which supports no surface.
    beam : BeamShape or None
        None: that of `score_ghosts`.
    light : (n,) or None
        Natural logarithm of power or reflectance.
    progress : Progress
    """
    beam = BEAM if beam is None else beam
    mixed = ~((score <= CLEAN) & (score < threshold))
    surfaces = find_surfaces(lay_ground(image, mixed, light), points, beam, progress)
    own = image.own[points]
    with np.errstate(invalid="ignore"):
        share = None if light is None else np.exp(light[points] - surfaces.light[:, 0])
        return Reasons(
            _sort(own, score[points] >= threshold, surfaces),
            surfaces.distance[:, :2] - own[:, None],
            number_members(image, points, surfaces)[:, :2],
            share,
            _measure_border(image, points, surfaces, beam),
            np.arctan(surfaces.slope[:, 0] * own / surfaces.distance[:, 0]),
        )


def _sort(own: Floats, ghost: Bools, surfaces: BeamSurfaces) -> AnyArray:
    first, second = (surfaces.distance[:, k] - own for k in (0, 1))
    reason = np.full(len(own), Reason.ON_SURFACE, np.uint8)
    reason[ghost] = Reason.BESIDE
    reason[ghost & (first * second < 0.0)] = Reason.BETWEEN
    steep = (surfaces.slope[:, 0] > STEEP) & ~(np.abs(second) < np.abs(first) * 3.0)
    reason[ghost & steep] = Reason.STEEP
    reason[ghost & (np.abs(first) <= ON_SURFACE)] = Reason.WEAK
    reason[ghost & ~np.isfinite(first)] = Reason.ALONE
    return reason


def _measure_border(
    image: GhostImage, points: Ints, surfaces: BeamSurfaces, beam: BeamShape
) -> Floats:
    step, diameter = measure_beams(image, points, beam)
    border: Floats = 0.5 * (surfaces.away[:, 1] - surfaces.away[:, 0]) * step / diameter
    return border
