"""From a request to the calibration of each leaf: its curve, its offset, what may be claimed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.fitting import fit
from app.core.phase import get_model
from app.core.planes import leaf_plane
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.claim import Calibration
from app.core.wrinkling.curve import KnownCurve, curve_of_fit, curve_of_model
from app.core.wrinkling.leaf import LeafPoints
from app.core.wrinkling.offset import Offset, OffsetKind, scatter_of
from app.model.leaf import Leaf
from app.model.project import Project
from app.model.scan import Channel
from app.services.wrinkles.gather import Gathered
from app.services.wrinkles.goniometer import USUAL_MODEL, read_goniometer
from app.services.wrinkles.pooling import pool_curve
from app.services.wrinkles.request import (
    CurveInUse,
    OwnCurve,
    ScanCurve,
    SpeciesSource,
    TableCurve,
    WrinkleRequest,
)
from app.services.wrinkles.scale import ChannelScale
from app.services.wrinkles.species import MODEL, find_species_curve

LEAST_LEAVES = 5
"""Leaves from whose planes the height of a species' curve is taken."""
FLATTEST = float(to_radians(55.0))
LEAST_SPAN = float(to_radians(10.0))
"""Local planes of a leaf must differ by so much for a curve of its own."""
NOISE_SPAN = 3.29
"""5 to 95 % of a normal distribution, in its σ."""
LEAST_INSIDE = 0.9
"""Share of a leaf's angles at which its own curve must fall."""
HINT = "Take one curve for all leaves (leave --own out), or a goniometer table (--curve)."
OfLeaf = Callable[[Leaf, Ints, LeafPoints], Calibration]


@dataclass(frozen=True, slots=True, eq=False)
class Calibrator:
    """The calibration of every leaf, and what is to be told of it."""

    of_leaf: OfLeaf
    warnings: tuple[str, ...] = ()


def calibrate(
    project: Project,
    scan: str,
    request: WrinkleRequest,
    channel: Channel,
    scale: ChannelScale,
    gathered: Gathered,
    progress: Progress = QUIET,
) -> Calibrator:
    """Find the curve that a request names.

    Raises
    ------
    LeafscopeError
        It cannot be had; the sentence says what is missing.
    """
    source = request.source
    if isinstance(source, ScanCurve):
        return _calibrate_by_scan(project, scan, source, scale, request, gathered, progress)
    if isinstance(source, OwnCurve):
        return _calibrate_by_itself(project, scan, source, scale, request, progress)
    if isinstance(source, TableCurve):
        curve, result = read_goniometer(source.path, scale.scale, source.model)
        curve = replace(curve, per_decade=scale.per_decade)
        return Calibrator(_same(_known(curve, request, scale)), tuple(result.warnings))
    if isinstance(source, SpeciesSource):
        return _calibrate_by_species(source, request, channel, scale, gathered)
    return _calibrate_in_use(project, scan, source, request, scale)


def _same(calibration: Calibration) -> OfLeaf:
    def of_leaf(_leaf: Leaf, _points: Ints, _measured: LeafPoints) -> Calibration:
        return calibration

    return of_leaf


def _known(curve: KnownCurve, request: WrinkleRequest, scale: ChannelScale) -> Calibration:
    """A curve of this leaf: known, or levelled."""
    if request.offset == "fit":
        return Calibration("levelled", curve)
    return Calibration("known", curve, _given_offset(request, scale))


def _given_offset(request: WrinkleRequest, scale: ChannelScale) -> Offset | None:
    if request.offset is None or request.offset == "fit":
        return None
    if not scale.told:
        raise WrongUse(
            "An offset is DN on a logarithmic scale and a factor on a linear one, and nobody "
            "told which scale this channel has.",
            "Name the instrument (--instrument), or the channel's kind (--channel "
            "NAME=WAVELENGTH:KIND).",
        )
    kind: OffsetKind = "added" if scale.scale == "log" else "factor"
    return Offset(kind, float(request.offset))


def _calibrate_by_scan(
    project: Project, scan: str, source: ScanCurve, scale: ChannelScale, request: WrinkleRequest,
    gathered: Gathered, progress: Progress,
) -> Calibrator:  # fmt: skip
    if request.offset not in (None, "fit"):
        raise WrongUse(
            "The curve through the leaves of a scan is levelled with each leaf: it has no offset "
            "that could be given.", "Leave --offset out, or name a curve (--curve, --species).",
        )  # fmt: skip
    curve, warnings = pool_curve(project, scan, gathered, scale, source.model, progress)
    return Calibrator(_same(Calibration("levelled", curve)), warnings)


def _calibrate_by_itself(
    project: Project, scan: str, source: OwnCurve, scale: ChannelScale, request: WrinkleRequest,
    progress: Progress,
) -> Calibrator:  # fmt: skip
    if request.offset not in (None, "fit"):
        raise WrongUse(
            "A leaf's own curve has no offset to itself.", "Leave it out, or name a curve."
        )
    model = get_model(source.model or USUAL_MODEL[scale.scale])

    def of_leaf(leaf: Leaf, points: Ints, measured: LeafPoints) -> Calibration:
        angle = to_radians(project.field(scan, "incidence", points, progress))
        used = np.isfinite(angle) & measured.usable
        sigma = to_radians(project.field(scan, "incidence_sigma", points, progress))[used]
        angle, value = angle[used], measured.intensity[used]
        if not _find_span(angle, sigma) >= LEAST_SPAN:
            raise BadInput(
                f"The local planes of {leaf.name} differ by less than "
                f"{to_degrees(LEAST_SPAN):g}°: it has no curve of its own.",
                HINT,
            )
        curve = curve_of_fit(fit(model, angle, value), scale.scale, f"fit of {leaf.name}")
        low, high = curve.monotone
        inside = ((angle >= low) & (angle <= high)).mean()
        if inside < LEAST_INSIDE or not curve.falls:
            raise BadInput(
                f"The curve through the points of {leaf.name} does not fall with the angle over "
                f"its own angles: intensity cannot be read backwards on it.",
                HINT,
            )
        return Calibration("levelled", curve, own=True)

    return Calibrator(of_leaf)


def _find_span(angle: Floats, sigma: Floats) -> float:
    """5 to 95 % of the angles of a leaf, less what the noise of its local planes spreads them."""
    known = sigma[np.isfinite(sigma)]
    if not len(known):
        return float("nan")
    low, high = np.quantile(angle, (0.05, 0.95))
    noise = NOISE_SPAN * float(np.median(known))
    return float(np.sqrt(max((high - low) ** 2 - noise**2, 0.0)))


def _calibrate_by_species(
    source: SpeciesSource, request: WrinkleRequest, channel: Channel, scale: ChannelScale,
    gathered: Gathered,
) -> Calibrator:  # fmt: skip
    if scale.scale == "log" and scale.per_decade is None:
        raise WrongUse(
            f"A curve of {source.species} becomes DN by the amplifier, and nobody told which.",
            "Name the instrument (--instrument), or calibrate the channel (--profile).",
        )
    printed = find_species_curve(source.species, channel.wavelength_nm)
    values = {"f": source.reflectance or 1.0, **printed.values}
    curve = curve_of_model(
        get_model(MODEL), values, origin=printed.title, per_decade=scale.per_decade,
        scale=scale.scale,
    )  # fmt: skip
    if request.offset == "fit":
        return Calibrator(_same(Calibration("levelled", curve)))
    offset = _given_offset(request, scale)
    warnings: tuple[str, ...] = ()
    if offset is None and source.reflectance is None:
        offset, warnings = _find_height(curve, gathered)
    elif scale.scale == "log" and source.reflectance is None:
        warnings = ("The offset is taken as the DN of a reflectance of 1.",)
    spread = scatter_of(source.scatter, scale.scale, scale.per_decade)
    found = Calibration("species", curve, offset, spread, source.scatter)
    return Calibrator(_same(found), warnings)


def _find_height(curve: KnownCurve, gathered: Gathered) -> tuple[Offset, tuple[str, ...]]:
    """Height of a species' curve: the median over the scan's leaves, each by its own plane."""
    heights = [
        height
        for measured in gathered.measured
        if (height := _height_of(measured, curve)) is not None
    ]
    if len(heights) < LEAST_LEAVES:
        raise BadInput(
            f"How bright the species is can be taken from {LEAST_LEAVES} leaves or more that face "
            f"the scanner within {to_degrees(FLATTEST):g}°; there are {len(heights)}.",
            "Give its reflectance (--reflectance), or fit the offset (--offset fit) to learn "
            "differences inside the leaf.",
        )
    middle = float(np.median(heights))
    # A median of n deviates has 1.2533 times the error of their mean.
    share = float(1.2533 * np.std(heights, ddof=1) / np.sqrt(len(heights)))
    found = f"The height of the curve is the median of {len(heights)} leaves of this scan."
    if curve.scale == "log":
        return Offset("added", middle, share), (found,)
    return Offset("factor", float(np.exp(middle)), float(np.exp(middle)) * share), (found,)


def _height_of(measured: LeafPoints, curve: KnownCurve) -> float | None:
    """What the intensity of a leaf is above the curve at its plane: DN, or a logarithm."""
    used = measured.usable
    if curve.scale == "linear":
        used &= measured.intensity > 0.0
    if used.sum() < LEAST_LEAVES:
        return None
    try:
        plane = leaf_plane(measured.solid, measured.scanner)
    except LeafscopeError:
        return None  # a leaf without a plane tells no height; others do
    if not plane.incidence < FLATTEST:
        return None
    middle = float(np.median(measured.intensity[used]))
    there = float(curve.evaluate(np.array([plane.incidence]))[0])
    return middle - there if curve.scale == "log" else float(np.log(middle / there))


def _calibrate_in_use(
    project: Project, scan: str, source: CurveInUse, request: WrinkleRequest, scale: ChannelScale
) -> Calibrator:
    parameters = project.state.scan(scan).parameters
    used = parameters.curve
    if used is None:
        raise BadInput(
            "No angular curve is in use.",
            "Fit a leaf in the phase lab and press 'Use this curve', or name another source.",
        )
    curve = curve_of_model(
        used.angular_model, used.values, used.within, used.origin or used.model, scale=scale.scale
    )
    curve = replace(curve, per_decade=scale.per_decade)
    if source.of_this_leaf or request.offset == "fit":
        return Calibrator(_same(_known(curve, request, scale)))
    spread = scatter_of(source.scatter, scale.scale, scale.per_decade)
    offset = _given_offset(request, scale)
    return Calibrator(_same(Calibration("species", curve, offset, spread, source.scatter)))
