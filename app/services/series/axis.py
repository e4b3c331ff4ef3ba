"""The axis of a holder: as typed, or followed from scan to scan and fitted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from app.core.carry import STILL, USUAL, Carried, Motion, Tolerance, carry
from app.core.errors import BadInput, WrongUse
from app.core.holder import Axis, FittedAxis, SeenPlane, fit_axis
from app.core.inverse_plane import inverse_range_plane
from app.core.sight import View
from app.model.scan import Vector
from app.model.series import HolderAxis
from app.services.series.reference import Reference

FIRST_ALONG = 0.03
"""Metres of range that a leaf may be away before anything is known of the axis."""
FOUND, WHOLE = 0.5, 0.9
"""Shares of a leaf from which its plane counts, and from which its middle does."""
FEWEST = 20
LEAST_SIGMA, MOST_SIGMA = 0.002, 0.1
USUAL_SIGMA = 0.005
"""Radians: standard errors of planes; below the least, wrinkles count more than noise."""
SENSE_WITHIN = np.pi / 3
MOST_SCANS = 12
"""Scans that the axis is followed through; more make it hardly better."""
Sighting = tuple[float, View]
"""A scan in which the axis is looked for: the holder's angle from the reference, radians."""


def parse_axis(text: str) -> HolderAxis:
    """Read ``x,y,z,dx,dy,dz``; raises `WrongUse` when it is something else."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 6:
        raise WrongUse(
            f"--axis takes six numbers x,y,z,dx,dy,dz or the word fit, not {text!r}.",
            "Example, a vertical axis: --axis 4,0,1.2,0,0,1",
        )
    return as_record(Axis.through(numbers[:3], numbers[3:]), "as given")


def as_record(axis: Axis, origin: str) -> HolderAxis:
    """An axis as a session keeps it."""
    return HolderAxis(_vector(axis.point), _vector(axis.direction), origin)


def _vector(values: Iterable[float]) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def choose_scans(angles: Sequence[float | None]) -> list[int]:
    """Which scans to follow leaves through: from small turns to large ones, evenly.

    Parameters
    ----------
    angles : sequence of float or None
        Of the holder from the reference, radians; None where it is not known.
    """
    known = [(abs(angle), number) for number, angle in enumerate(angles) if angle is not None]
    order = [number for _, number in sorted(known)]
    if len(order) <= MOST_SCANS:
        return order
    places = np.unique(np.linspace(0, len(order) - 1, MOST_SCANS).round().astype(int))
    return [order[place] for place in places]


def choose_far_scan(angles: Sequence[float | None]) -> int | None:
    """The scan that tells best which way a holder turns: the largest turn up to 60°.

    With small turns both ways look alike. None where nothing turns.
    """
    known = [(abs(a), k) for k, a in enumerate(angles) if a is not None and a != 0.0]
    within = [pair for pair in known if pair[0] <= SENSE_WITHIN]
    if within:
        return max(within)[1]
    return min(known)[1] if known else None


def find_axis(
    reference: Reference, scans: Iterable[Sighting], tolerance: Tolerance = USUAL
) -> FittedAxis:
    """Follow the leaves from small turns to large ones, and fit the axis.

    At first leaves are looked for where they were; from the second angle on, where the axis found
    so far turns them. Each scan is looked at once.

    Raises
    ------
    BadInput
        No leaf could be followed over 2°.
    """
    planes: list[SeenPlane] = []
    fitted: FittedAxis | None = None
    error = BadInput("The axis cannot be told: no scan could be read.")
    for angle, view in scans:
        if fitted is None:
            found = carry(view, reference.patterns, STILL, _widen(reference, angle, tolerance))
        else:
            found = carry(view, reference.patterns, Motion(fitted.axis, angle), tolerance)
        planes += _see_planes(reference, view, angle, found)
        try:
            fitted = fit_axis(planes)
        except BadInput as reason:
            error = reason
    if fitted is None:
        raise error
    return fitted


def _widen(reference: Reference, angle: float, tolerance: Tolerance) -> Tolerance:
    """Tolerance for leaves that an unknown axis near them has turned."""
    middles = np.array([pattern.xyz.mean(axis=0) for pattern in reference.patterns])
    lever = float(np.linalg.norm(middles - middles.mean(axis=0), axis=1).max())
    turned = min(abs(angle), np.pi / 2)
    return replace(
        tolerance,
        along=FIRST_ALONG + lever * float(np.sin(turned)),
        movement=tolerance.movement + lever * float(1.0 - np.cos(turned)),
    )


def _see_planes(
    reference: Reference, view: View, angle: float, found: list[Carried]
) -> list[SeenPlane]:
    planes = []
    for number, (leaf, one) in enumerate(zip(reference.leaves, found, strict=True)):
        if one.share < FOUND or len(one.rows) < FEWEST:
            continue
        try:
            plane = inverse_range_plane(view.xyz[one.rows], view.scanner)
        except BadInput:
            continue  # on edge: other scans tell
        if not plane.sigma < MOST_SIGMA:
            continue
        # Beams that a steep leaf catches in part flatten it, which σ does not know.
        weight = USUAL_SIGMA / max(plane.sigma, LEAST_SIGMA) * np.cos(plane.incidence) ** 2
        whole = leaf.pattern.free and one.share > WHOLE
        planes.append(SeenPlane(number, angle, plane.normal, plane.point, float(weight), whole))
    return planes


def choose_sense(
    axis: HolderAxis, reference: Reference, scan: Sighting, tolerance: Tolerance = USUAL
) -> HolderAxis:
    """The axis, turned round where the leaves are found better by turning the other way."""
    angle, view = scan
    line, exact = Axis.through(axis.point, axis.direction), replace(tolerance, movement=0.0)
    forth = _agree(view, reference, Motion(line, angle), exact)
    back = _agree(view, reference, Motion(line, -angle), exact)
    if back > forth:
        return as_record(line.reversed(), f"{axis.origin}, turned the other way round")
    return axis


def _agree(view: View, reference: Reference, motion: Motion, tolerance: Tolerance) -> float:
    """How much of the leaves is found, and how well their planes look as expected."""
    score = 0.0
    for one in carry(view, reference.patterns, motion, tolerance):
        try:
            plane = inverse_range_plane(view.xyz[one.rows], view.scanner)
        except BadInput:
            continue
        score += one.share * abs(float(plane.normal @ one.normal))
    return score
