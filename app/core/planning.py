"""What a scan will show of a leaf: footprint, points, full hits, ghosts, and the steepest angle.

A leaf is an ellipse, flat, and turned about its length, so that it looks narrower: the worst case.
The beam is a disc as seen along itself. A place of the disc's middle that lies so far within the
leaf's outline (as seen from the scanner) hits it in full, in part, or not at all, and the areas of
these places over the area between neighbouring beams are the numbers of points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from app.core.arrays import AnyArray, Bools, Floats
from app.core.ellipse import parallel_area
from app.core.errors import WrongUse
from app.core.footprint import check_beam, footprint_axis
from app.core.mixing import Mixing, covered_share, mixed_range

OFF = 0.006
"""Metres: a range farther than this from all surfaces of its beam is a ghost."""
BANDS, STRIPS = 16, 12
"""Bands of places from just outside the border to just inside, and even strips of each."""
MIXTURES = 2001
SMALLEST, LARGEST = -8.0, 8.0
"""Decades of mixtures that are tabulated."""
FINE = 1.0
"""Degrees from one tried angle to the next; between them by a straight line."""
STEEPEST = 89.0

Bound = Literal["footprint", "full hits", "ghosts"]
BOUNDS: tuple[Bound, ...] = ("footprint", "full hits", "ghosts")


@dataclass(frozen=True, slots=True)
class Sight:
    """Beam, leaf and what stands behind it.

    Attributes
    ----------
    beam_radius : float
        At the exit, metres.
    half_divergence : float
        Half of the full divergence, radians.
    step : float
        Between neighbouring beams, radians.
    length, width : float
        Of the leaf, metres.
    gap : float
        From the leaf to what stands behind it, metres; inf: nothing does, and there are no ghosts.
    mixing : PhaseMixing or PulseMixing
    contrast : float
        Reflectance of what stands behind over the leaf's.
    """

    beam_radius: float
    half_divergence: float
    step: float
    length: float
    width: float
    gap: float
    mixing: Mixing
    contrast: float = 1.0

    def __post_init__(self) -> None:
        check_beam(self.beam_radius, self.half_divergence)
        sizes = (("A step", self.step), ("The leaf's length", self.length),
                 ("The leaf's width", self.width))  # fmt: skip
        for name, size in sizes:
            if not 0.0 < size < np.inf:
                raise WrongUse(f"{name} must be above 0, not {size:g}.")
        if not (self.gap > 0.0 and 0.0 < self.contrast < np.inf):
            raise WrongUse(
                "What stands behind a leaf needs a distance and a reflectance above 0.",
                "Say that nothing stands there where it is the sky.",
            )


@dataclass(frozen=True, slots=True)
class Limits:
    """What is still usable.

    Attributes
    ----------
    footprint : float
        Most of the leaf's width that the footprint may be long.
    full_hits : float
        Fewest beams that fall wholly on the leaf.
    ghosts : float
        Largest share of ghosts among the leaf's points.
    """

    footprint: float = 0.45
    full_hits: float = 50.0
    ghosts: float = 0.4

    def __post_init__(self) -> None:
        if not (self.footprint > 0.0 and self.full_hits >= 0.0 and self.ghosts > 0.0):
            raise WrongUse("Limits of footprint and ghosts lie above 0, that of full hits from 0.")


class Prospect(NamedTuple):
    """What is to be expected, arrays of one shape.

    footprint: major axis, metres (inf where the beam no longer meets the leaf's plane). points:
    beams whose middle falls on the leaf. full_hits: beams that fall on it wholly. ghosts: their
    share among the points that are on the leaf or ghosts; NaN where there are none.
    """

    footprint: Floats
    points: Floats
    full_hits: Floats
    ghosts: Floats


class Steepest(NamedTuple):
    """Largest usable angle of incidence, radians (NaN: none), and the limit that binds there."""

    incidence: Floats
    bound: AnyArray  # index into BOUNDS


def foresee(distance: npt.ArrayLike, incidence: npt.ArrayLike, sight: Sight) -> Prospect:
    """What a scan at these ranges and angles of incidence will show of the leaf.

    Parameters
    ----------
    distance : array_like
        Range, metres.
    incidence : array_like
        Angle of incidence, radians from 0 to below π/2; broadcast against `distance`.
    sight : Sight

    Returns
    -------
    Prospect

    Raises
    ------
    WrongUse
        A range is not above 0, or an angle outside 0 to below 90 degrees.
    """
    r, omega = np.broadcast_arrays(
        np.asarray(distance, np.float64), np.asarray(incidence, np.float64)
    )
    if not ((r > 0.0) & (r < np.inf)).all():
        raise WrongUse("A range must be above 0 m.")
    if not ((omega >= 0.0) & (omega < np.pi / 2)).all():
        raise WrongUse(
            "An angle of incidence lies from 0 to below 90 degrees: at 90 the beam runs along the "
            "leaf and has no footprint on it."
        )
    axis = footprint_axis(r, omega, sight.beam_radius, sight.half_divergence)
    long, wide = sight.length / 2.0, sight.width / 2.0 * np.cos(omega)
    spot = sight.beam_radius + r * np.tan(sight.half_divergence)
    cell = (r * sight.step) ** 2
    full = parallel_area(long, wide, spot) / cell
    return Prospect(axis, np.pi * long * wide / cell, full, _ghost_share(r, omega, sight))


def full_leaf_angle(distance: npt.ArrayLike, share: float, sight: Sight) -> Floats:
    """Angle of incidence at which the footprint is as long as a share of the leaf's width.

    Balduzzi's equation 4, D cos ω (1 − tan²ω tan²δ) = 2 (r₀ + d tan δ), is of the second degree
    in cos ω.

    Returns
    -------
    array
        Radians; 0 where it is longer even at 0.
    """
    d, wanted = np.asarray(distance, np.float64), share * sight.width
    spread = np.tan(sight.half_divergence)
    beam = sight.beam_radius + d * spread
    both = wanted * (1.0 + spread**2)
    cosine = (beam + np.sqrt(beam**2 + both * wanted * spread**2)) / both
    angle: Floats = np.arccos(np.minimum(cosine, 1.0))
    return angle


def find_steepest(distance: npt.ArrayLike, sight: Sight, limits: Limits = Limits()) -> Steepest:
    """The largest angle of incidence up to which nothing exceeds its limit, at each range.

    Parameters
    ----------
    distance : (n,) array_like
        Metres.
    sight : Sight
    limits : Limits

    Returns
    -------
    Steepest
        Of (n,) arrays; where not even 0 degrees are usable the bound is that which is exceeded
        there, the first of them in the order of `BOUNDS`.
    """
    d = np.atleast_1d(np.asarray(distance, np.float64))
    tried = np.deg2rad(np.arange(0.0, STEEPEST + FINE / 2, FINE))
    seen = foresee(d[:, None], tried[None, :], sight)
    at_right_angle = footprint_axis(d, 0.0, sight.beam_radius, sight.half_divergence)
    fits = at_right_angle <= limits.footprint * sight.width
    ends = np.stack(
        [
            np.where(fits, full_leaf_angle(d, limits.footprint, sight), np.nan),
            _first_crossing(tried, limits.full_hits - seen.full_hits),
            _first_crossing(tried, np.nan_to_num(seen.ghosts, nan=0.0) - limits.ghosts),
        ]
    )
    bound = np.argmin(np.where(np.isnan(ends), -1.0, ends), axis=0)
    return Steepest(np.where(np.isnan(ends).any(axis=0), np.nan, ends.min(axis=0)), bound)


def _first_crossing(tried: Floats, excess: Floats) -> Floats:
    """Where each row of `excess` first rises above 0: its end where it never does, NaN at once."""
    over: Bools = excess > 0.0
    first = np.where(over.any(axis=1), over.argmax(axis=1), len(tried) - 1)
    rows, before = np.arange(len(excess)), np.maximum(first - 1, 0)
    low, high = excess[rows, before], excess[rows, first]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(high > low, -low / (high - low), 1.0)
    place = tried[before] + np.clip(share, 0.0, 1.0) * (tried[first] - tried[before])
    place = np.where(over.any(axis=1), place, tried[-1])
    return np.where(over[:, 0], np.nan, place)


def _ghost_share(r: Floats, omega: Floats, sight: Sight) -> Floats:
    """Ghosts over ghosts and leaf points, by strips along the border of the leaf.

    On a steep leaf a footprint reaches over many ranges, and a ghost counts only beyond the
    farthest of them: half of the depth that the hit part spans is taken for that.
    """
    if not np.isfinite(sight.gap):
        return np.zeros(r.shape)
    edges = np.linspace(-1.0, 1.0, BANDS + 1)
    fine = np.linspace(-1.0, 1.0, BANDS * STRIPS + 1)
    middle = (fine[1:] + fine[:-1]) / 2
    spot = (sight.beam_radius + r * np.tan(sight.half_divergence))[..., None]
    long, wide = sight.length / 2.0, (sight.width / 2.0 * np.cos(omega))[..., None]
    areas = parallel_area(long, wide, edges * spot)
    strips = np.repeat(areas[..., :-1] - areas[..., 1:], STRIPS, axis=-1) / STRIPS
    share = covered_share(middle)
    faintness = (sight.contrast / np.cos(omega) * (r / (r + sight.gap)) ** 2)[..., None]
    place = _look_up_range(np.log10(faintness), np.log10((1.0 - share) / share), sight)
    depth = spot * np.tan(omega)[..., None] * ((1.0 + middle) / 2.0)
    on_leaf = np.abs(place) <= OFF + depth
    behind = np.abs(place - sight.gap) <= OFF
    ghosts = (strips * ~(on_leaf | behind)).sum(axis=-1)
    leaf = (strips * on_leaf).sum(axis=-1) + areas[..., -1]
    with np.errstate(invalid="ignore"):
        found: Floats = ghosts / (ghosts + leaf)
    return found


def _look_up_range(faintness: Floats, mixture: Floats, sight: Sight) -> Floats:
    """As `mixed_range` for many ratios (sums of decades), by the nearest that is tabulated."""
    table = mixed_range(np.logspace(SMALLEST, LARGEST, MIXTURES), sight.gap, sight.mixing)
    decade = (MIXTURES - 1) / (LARGEST - SMALLEST)
    place = np.rint((faintness + mixture - SMALLEST) * decade)
    found: Floats = table[np.clip(place, 0, MIXTURES - 1).astype(np.int64)]
    return found
