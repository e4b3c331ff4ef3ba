"""One curve through all leaves of a scan: what can be had when nothing is known of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.fitting import fit
from app.core.phase import get_model
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.curve import KnownCurve, curve_of_fit, curve_of_model
from app.core.wrinkling.leaf import LeafPoints
from app.core.wrinkling.means import TO_SIGMA
from app.core.wrinkling.offset import LN10
from app.model.project import Project
from app.services.wrinkles.gather import Gathered
from app.services.wrinkles.goniometer import USUAL_MODEL
from app.services.wrinkles.scale import ChannelScale

MOST_POINTS, LEAST_POINTS = 300, 10
"""Of one leaf: a large one must not drown the others."""
LEAST_SPAN = float(to_radians(20.0))
"""5 to 95 % of the angles must lie so far apart, or the shape is that of Lambert."""
LARGEST_SIGMA = float(to_radians(5.0))
"""Local planes less certain than this are not used."""
ODD, LEAST_ODD = 4.0, 0.25
"""Leaves so many robust σ, and such a share, from the others are walls, panels or other plants."""
ROUNDS = 6
LEAST_INSIDE = 0.9
"""Share of the angles at which the curve must fall."""
LAMBERT = "lambert"
SEED = 20261123
NONE = (
    "The leaves of this scan have no curve of their own: their angles are too alike, or their "
    "intensity does not fall evenly with the angle."
)
LAMBERT_TAKEN = (
    f"{NONE} The cosine of a matt leaf was taken instead; a goniometer table (--curve FILE) or a "
    "species (--species NAME --offset fit) is surer."
)
TELL_SCALE = (
    "Name the instrument (--instrument) or the channel's kind (--channel NAME=WAVELENGTH:KIND), "
    "and the cosine of a matt leaf can be taken; or give a goniometer table (--curve FILE)."
)


@dataclass(frozen=True, slots=True, eq=False)
class _Pool:
    """Angles, intensities and numbers of the leaves that they belong to."""

    angle: Floats
    value: Floats
    leaf: Ints

    def take(self, chosen: Bools) -> _Pool:
        return _Pool(self.angle[chosen], self.value[chosen], self.leaf[chosen])


def pool_curve(
    project: Project,
    scan: str,
    gathered: Gathered,
    scale: ChannelScale,
    model: str | None = None,
    progress: Progress = QUIET,
) -> tuple[KnownCurve, tuple[str, ...]]:
    """The curve through the local planes of all leaves, and what is to be told of it.

    Leaves that are brighter or darker than the others by far are left out. DN of a logarithmic
    scale are made linear first where its DN per decade are known. Leaves that stand at angles
    too alike get the cosine of Lambert, as long as the scale is known.

    Raises
    ------
    BadInput
        There is no such curve; the sentence says what to give instead.
    """
    pool = _draw(project, scan, gathered, scale, progress)
    if model is None and _find_span(pool.angle) < LEAST_SPAN:
        return _take_lambert(scale), (LAMBERT_TAKEN,)
    model = model or USUAL_MODEL["linear" if scale.per_decade else scale.scale]
    curve, kept = _fit(pool, scale, model), np.ones(len(pool.angle), bool)
    for _ in range(ROUNDS):
        # Of all again: the first curve, bent by a wall, may have turned a leaf away.
        alike = _find_alike(pool, curve)
        if (alike == kept).all():
            break
        kept, curve = alike, _fit(pool.take(alike), scale, model)
    pool = pool.take(kept)
    low, high = curve.monotone
    inside = ((pool.angle >= low) & (pool.angle <= high)).mean()
    if not (curve.falls and inside >= LEAST_INSIDE):
        return _take_lambert(scale), (LAMBERT_TAKEN,)
    count = len(np.unique(pool.leaf))
    first, last = (float(to_degrees(end)) for end in np.quantile(pool.angle, (0.05, 0.95)))
    origin = f"{model} through {count} leaves of this scan, {first:.0f}° to {last:.0f}°"
    return replace(curve, origin=origin), ()


def _draw(
    project: Project, scan: str, gathered: Gathered, scale: ChannelScale, progress: Progress
) -> _Pool:
    """Some full hits of each leaf, and the angles of the local planes there."""
    random = np.random.default_rng(SEED)
    points, values, numbers = [], [], []
    for number, (_, own, measured) in enumerate(gathered):
        usable = np.flatnonzero(_find_usable(measured, scale))
        if len(usable) >= LEAST_POINTS:
            some = random.choice(usable, min(len(usable), MOST_POINTS), replace=False)
            points.append(own[some])
            values.append(measured.intensity[some])
            numbers.append(np.full(len(some), number))
    if not points:
        raise BadInput(
            f"No leaf has {LEAST_POINTS} points that the beam hits wholly.",
            "Scan from nearer or with a finer step.",
        )
    every, place = np.unique(np.concatenate(points), return_inverse=True)
    angle = to_radians(project.field(scan, "incidence", every, progress))[place]
    sigma = to_radians(project.field(scan, "incidence_sigma", every, progress))[place]
    pool = _Pool(angle, np.concatenate(values), np.concatenate(numbers))
    # Where no error can be told (balls) the angles are used all the same.
    return pool.take(np.isfinite(angle) & ~(sigma > LARGEST_SIGMA))


def _find_usable(measured: LeafPoints, scale: ChannelScale) -> Bools:
    usable = measured.usable
    return usable & (measured.intensity > 0.0) if scale.scale == "linear" else usable


def _find_span(angle: Floats) -> float:
    low, high = np.quantile(angle, (0.05, 0.95)) if len(angle) else (0.0, 0.0)
    return float(high - low)


def _fit(pool: _Pool, scale: ChannelScale, model: str) -> KnownCurve:
    if not scale.per_decade:
        return curve_of_fit(fit(model, pool.angle, pool.value), scale.scale)
    with np.errstate(over="ignore"):
        result = fit(model, pool.angle, 10.0 ** (pool.value / scale.per_decade))
    return curve_of_model(
        result.angular_model, result.values, result.valid_range, per_decade=scale.per_decade
    )


def _find_alike(pool: _Pool, curve: KnownCurve) -> Bools:
    """Points of leaves that are about as bright as most, each at its own angles."""
    there = curve.evaluate(pool.angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = pool.value - there if curve.scale == "log" else np.log(pool.value / there)
    numbers = np.unique(pool.leaf)
    height = np.array([np.median(away[pool.leaf == number]) for number in numbers])
    middle = np.median(height)
    share = curve.per_decade / LN10 if curve.per_decade else 1.0
    spread = TO_SIGMA * float(np.median(np.abs(height - middle)))
    alike = np.abs(height - middle) <= max(ODD * spread, LEAST_ODD * share)
    return np.isin(pool.leaf, numbers[alike])


def _take_lambert(scale: ChannelScale) -> KnownCurve:
    if not scale.told:
        raise BadInput(NONE, TELL_SCALE)
    return curve_of_model(
        get_model(LAMBERT), {"f": 1.0}, origin="cosine (Lambert)", per_decade=scale.per_decade,
        scale=scale.scale,
    )  # fmt: skip
