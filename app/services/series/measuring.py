"""Rows of a series' table: what was found of each leaf in one scan, and its channels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.core.arrays import Ints
from app.core.footprint import footprint_axis
from app.core.progress import QUIET, Progress
from app.core.radiometry.partial_hits import FULL_HIT
from app.core.units import to_degrees, to_mm
from app.model.leaf import Leaf
from app.model.operations import PutLeaf, Several
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import Explicit
from app.services.beams import propose_beam
from app.services.leaves import Row, measure_leaves
from app.services.opening import set_parameters
from app.services.series.carrying import Found
from app.services.series.entries import Entry
from app.services.series.reference import Reference


def name_row(entry: Entry, leaf: str, name: str) -> Row:
    """What every row says: which leaf, and which scan."""
    return {
        "leaf": leaf,
        "name": name,
        "file": entry.file.name,
        "angle_deg": entry.angle_deg,
        "hours": entry.hours,
        "treatment": entry.treatment,
        "label": entry.label,
    }


def unread_rows(entry: Entry, reference: Reference, reason: str) -> list[Row]:
    """Rows for a scan that could not be read."""
    return [
        name_row(entry, leaf.key, leaf.name) | {"verdict": "unread", "reason": reason, "points": 0}
        for leaf in reference.leaves
    ]


def measure_found(
    project: Project,
    scan: str,
    entry: Entry,
    found: Sequence[Found],
    full_hits: bool = False,
    progress: Progress = QUIET,
) -> list[Row]:
    """Put the leaves that were found into a project and measure them, a row each.

    Parameters
    ----------
    project : Project
    scan : str
    entry : Entry
    found : sequence of Found
    full_hits : bool
        Leave out points that the beam hits in part (needs rows, columns and the beam).
    progress : Progress
    """
    state = project.state.scan(scan)
    if state.parameters.beam is None:
        set_parameters(project, scan, beam=propose_beam(state.scan))
    members = {one.leaf.key: _choose(project, scan, one.rows, full_hits) for one in found}
    put_leaves(project, scan, found, members)
    measured = {str(row["leaf"]): row for row in measure_leaves(project, scan, None, progress)}
    rows = []
    for one in found:
        row = name_row(entry, one.leaf.key, one.leaf.name) | _tell_found(one)
        row |= {"points": len(members[one.leaf.key])}
        if len(members[one.leaf.key]):
            row |= measured[one.leaf.key] | {"name": one.leaf.name}
            row |= _tell_plane(one) | _tell_footprint(project, scan, one)
            row |= _count(project, scan, members[one.leaf.key])
        rows.append(row)
    return rows


def _choose(project: Project, scan: str, rows: Ints, full_hits: bool) -> Ints:
    if not full_hits or not len(rows):
        return rows
    share = project.field(scan, "hit_fraction", rows)
    return rows[share >= FULL_HIT]


def put_leaves(
    project: Project, scan: str, found: Sequence[Found], members: dict[str, Ints]
) -> None:
    """Make leaves of what was found, as one step of the history."""
    steps = []
    for one in found:
        points = PointSet(members[one.leaf.key])
        if len(points):
            leaf = Leaf(one.leaf.key, scan, one.leaf.name, points, (Explicit(points),))
            steps.append(PutLeaf(leaf.key, leaf, "Carry"))
    if steps:
        project.do(Several(f"Carry {len(steps)} leaves", tuple(steps)))


def _tell_found(one: Found) -> Row:
    return {
        "verdict": one.verdict,
        "reason": one.reason,
        "matched_share": _number(one.share),
        "overlap_share": _number(one.overlap),
        "offset_mm": _number(to_mm(one.offset)),
        "incidence_carried_deg": _number(to_degrees(one.carried_incidence)),
    }


def _tell_plane(one: Found) -> Row:
    """The plane of the leaf in this scan, by the inverse range: noise along the beam is no tilt."""
    if one.plane is None:
        told = ("incidence_plane_deg", "incidence_plane_sigma_deg")
        return {**dict.fromkeys(told), "plane_method": "none: on edge, or too few points"}
    return {
        "incidence_plane_deg": _number(to_degrees(one.plane.incidence)),
        "incidence_plane_sigma_deg": _number(to_degrees(one.plane.sigma)),
        "plane_rmse_m": _number(one.plane.rmse),
        "plane_outlier_share": _number(one.plane.outlier_share),
        "plane_method": one.plane.method,
    }


def _tell_footprint(project: Project, scan: str, one: Found) -> Row:
    """Footprint at the middle of the leaf over the leaf's size; empty where it has no end."""
    state = project.state.scan(scan)
    beam = state.parameters.beam
    if beam is None or one.plane is None:
        return {}
    away = float(np.linalg.norm(one.plane.point - state.scan.scanner("the footprint")))
    axis = footprint_axis(away, one.plane.incidence, beam.radius, beam.half_divergence)
    return {"footprint_share": _number(float(axis) / one.leaf.diameter)}


def _count(project: Project, scan: str, rows: Ints) -> Row:
    """How many points have a value in each channel."""
    return {
        f"{channel.name}_n": int(
            np.count_nonzero(np.isfinite(project.field(scan, channel.name, rows)))
        )
        for channel in project.state.scan(scan).channels
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
