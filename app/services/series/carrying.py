"""Leaves carried into one scan of a series, and how far each can be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.carry import STILL, USUAL, Carried, Motion, Tolerance, carry
from app.core.errors import BadInput
from app.core.holder import Axis
from app.core.incidence import incidence_angle
from app.core.inverse_plane import inverse_range_plane
from app.core.planes import LeafPlane
from app.core.sight import View
from app.core.units import to_degrees, to_mm, to_radians
from app.model.points import PointSet
from app.model.series import HolderAxis
from app.services.series.reference import CarriedLeaf, Reference, alive_rows

Verdict = Literal["sure", "check", "vanished", "corrected", "unread"]
VANISHED = 0.2
"""Share of a leaf that must be found; what is less is something else at its place."""
FEWEST = 10
SURE = 0.8
"""Share of a leaf above which nobody needs to look."""
OVERLAP = 0.1
FAR = 0.005
"""Metres by which a leaf may be off its place along the beam."""
TURNED_DEG = 5.0
SIGMAS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A leaf in one scan of the series.

    Attributes
    ----------
    leaf : CarriedLeaf
    rows : (m,) int64
        Its points; none where it vanished.
    verdict : str
        sure; check: somebody should look; vanished; corrected: the user said so.
    reason : str
        Why, in words; empty when sure.
    share, overlap : float
        See `app.core.carry.Carried`; NaN for corrected leaves.
    offset : float
        Metres along the beam from where it was carried to.
    carried_incidence : float
        Radians: angle at which the beam meets the plane of the leaf as carried.
    plane : LeafPlane or None
        Of the points found.
    """

    leaf: CarriedLeaf
    rows: Ints
    verdict: Verdict
    reason: str
    share: float
    overlap: float
    offset: float
    carried_incidence: float
    plane: LeafPlane | None


def motion_of(axis: HolderAxis | None, angle_deg: float | None, from_deg: float | None) -> Motion:
    """How leaves came from the reference, whose holder stood at `from_deg`, to another scan."""
    if axis is None:
        return STILL
    if angle_deg is None or from_deg is None:
        raise BadInput(
            "The angle of its holder is not known.", "Give it, or carry with --same-pose."
        )
    turned = float(to_radians(angle_deg - from_deg))
    return Motion(Axis.through(axis.point, axis.direction), turned)


def carry_leaves(
    view: View,
    reference: Reference,
    motion: Motion = STILL,
    tolerance: Tolerance = USUAL,
    corrections: Mapping[str, PointSet] | None = None,
) -> list[Found]:
    """Find the leaves of a reference in another scan; what the user said counts more.

    Points that were given to a leaf by hand are no other leaf's.
    """
    said = corrections or {}
    usable = view.usable.copy()
    for members in said.values():
        usable[alive_rows(view, members.indices)] = False
    others = View(view.xyz, view.scanner, usable)
    found = carry(others, reference.patterns, motion, tolerance)
    return [
        _correct(view, leaf, one, said[leaf.key], motion)
        if leaf.key in said
        else _judge(view, leaf, one, motion)
        for leaf, one in zip(reference.leaves, found, strict=True)
    ]


def keep_leaves(view: View, reference: Reference) -> list[Found]:
    """The leaves of the reference in the reference's own scan: nothing is carried."""
    found = []
    for leaf in reference.leaves:
        plane = _fit(view, leaf.rows)
        angle = float("nan") if plane is None else plane.incidence
        found.append(Found(leaf, leaf.rows, "sure", "", 1.0, 0.0, 0.0, angle, plane))
    return found


def _correct(
    view: View, leaf: CarriedLeaf, found: Carried, said: PointSet, motion: Motion
) -> Found:
    rows = alive_rows(view, said.indices)
    reason = "" if len(rows) else "The user says that it is not there."
    nan = float("nan")
    incidence, plane = _expect(view, leaf, found, motion), _fit(view, rows)
    return Found(leaf, rows, "corrected", reason, nan, nan, nan, incidence, plane)


def _judge(view: View, leaf: CarriedLeaf, found: Carried, motion: Motion) -> Found:
    incidence = _expect(view, leaf, found, motion)
    rows, plane = found.rows, _fit(view, found.rows)
    verdict: Verdict = "sure"
    if found.share < VANISHED or len(rows) < FEWEST:
        reason = f"{found.share:.0%} of it and {len(rows)} points were found: it is not there."
        verdict, rows, plane = "vanished", rows[:0], None
    else:
        reason = " ".join(_doubt(found, plane, incidence))
        verdict = "check" if reason else "sure"
    told = (found.share, found.overlap, found.offset)
    return Found(leaf, rows, verdict, reason, *told, incidence, plane)


def _doubt(found: Carried, plane: LeafPlane | None, expected: float) -> list[str]:
    """Reasons to look at a leaf, a sentence each."""
    said = []
    if found.share < SURE:
        said.append(f"Only {found.share:.0%} of it was found.")
    if found.overlap > OVERLAP:
        said.append(f"{found.overlap:.0%} of its points could be another leaf's.")
    if abs(found.offset) > FAR:
        said.append(f"It is {to_mm(abs(found.offset)):.0f} mm from where it was carried to.")
    if plane is not None:
        off = to_degrees(plane.incidence - expected)
        if abs(off) > max(TURNED_DEG, SIGMAS * to_degrees(np.nan_to_num(plane.sigma))):
            said.append(f"Its plane is at {abs(off):.0f}° from where it was carried to.")
    return said


def _expect(view: View, leaf: CarriedLeaf, found: Carried, motion: Motion) -> float:
    middle = motion.place(leaf.pattern.xyz.mean(axis=0)[None])
    normal: Floats = found.normal[None]
    return float(incidence_angle(middle, normal, view.scanner)[0])


def _fit(view: View, rows: Ints) -> LeafPlane | None:
    try:
        return inverse_range_plane(view.xyz[rows], view.scanner)
    except BadInput:
        return None  # a few points, or a leaf on edge: it has points and no plane
