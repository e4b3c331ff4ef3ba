"""Angles as fields: between beam and surface, and how far intensity tells another one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.incidence import LocalPlanes
from app.core.neighbours.choice import Neighbours
from app.core.units import to_degrees, to_mm
from app.model.fields import Computed, Evaluation, FieldSpec, pick_rows
from app.model.neighbours import neighbours_of
from app.model.parameters import Parameters

WIDENED = 1.25
"""Radii from which on a window is a wider one, and not one rounded to whole cells."""
LOOKING = 0.3
"""Share of the progress that is given to finding rows and columns."""


def compute_incidence(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle between beam and local normal, degrees (Junttila 2016, 2.6.1).

    The same planes give its standard error and the window that was used: they lie beside it.
    """
    from app.core.incidence import incidence_angle, local_planes

    state = evaluation.subject.state
    scan, parameters = state.scan, state.parameters
    scanner = scan.scanner("the incidence angle")
    neighbours = neighbours_of(scan, evaluation.progress.part(0.0, LOOKING))
    planes = local_planes(
        scan.xyz,
        scanner,
        points,
        parameters.radius,
        neighbours.grid,
        evaluation.progress.part(LOOKING, 1.0),
        parameters.estimator,
    )
    angles = incidence_angle(pick_rows(scan.xyz, points), planes.normals, scanner)
    notes = _tell_neighbours(neighbours, planes, parameters)
    notes |= _tell_sizes(planes, np.isfinite(angles), parameters.radius)
    beside = {"sigma": planes.sigma, "width": planes.width}
    return Computed(to_degrees(angles), notes, planes.seconds, beside)


def _tell_neighbours(
    neighbours: Neighbours, planes: LocalPlanes, parameters: Parameters
) -> dict[str, object]:
    voxels = planes.method == "voxel hash"
    refused = neighbours.grid is not None and (voxels or planes.estimator != parameters.estimator)
    return {
        "neighbours": planes.method if voxels else neighbours.method,
        "reason": planes.reason if refused else neighbours.reason,
        "estimator": planes.estimator,
        "by_balls": planes.balls,
        "radius_m": parameters.radius,
    }


def _tell_sizes(planes: LocalPlanes, found: Bools, radius: float) -> dict[str, object]:
    width, sigma = planes.width[found], planes.sigma[found]
    sigma = sigma[np.isfinite(sigma)]
    return {
        "median_width_m": float(np.median(width)) if len(width) else None,
        "widened": int((width > radius * WIDENED).sum()),
        "median_sigma_deg": float(to_degrees(np.median(sigma))) if len(sigma) else None,
    }


def compute_incidence_sigma(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Standard error of the incidence angle, degrees; NaN where it cannot be told."""
    sigma = evaluation.read_beside("incidence", "sigma", points)
    return Computed(to_degrees(sigma.astype(np.float64)))


def compute_incidence_width(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Half-width of the window (or radius of the ball) of each plane, mm; NaN without one."""
    width = evaluation.read_beside("incidence", "width", points).astype(np.float64)
    found = np.isfinite(evaluation.read("incidence", points)) & (width > 0.0)
    return Computed(to_mm(np.where(found, width, np.nan)))


def compute_delta_omega(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle from intensity less the angle of the leaf's plane, degrees (Balduzzi 2011)."""
    asked = np.arange(evaluation.size) if points is None else points
    plane_angle = spread_over_leaves(evaluation, asked, leaf_incidence)
    values = np.full(len(asked), np.nan)
    rows = np.flatnonzero(np.isfinite(plane_angle))
    if len(rows):
        found = evaluation.read("incidence_from_intensity", asked[rows])
        values[rows] = found - plane_angle[rows]
    return Computed(values, {"leaves": len(evaluation.subject.leaves)})


def spread_over_leaves(
    evaluation: Evaluation, asked: Ints, measure: Callable[[Evaluation, Ints], float]
) -> Floats:
    """What is measured of a leaf, at each point asked for; NaN outside leaves.

    Only leaves that hold such a point are measured.
    """
    wanted = np.zeros(evaluation.size, bool)
    wanted[asked] = True
    value_of = np.full(evaluation.size, np.nan)
    for leaf in evaluation.subject.leaves:
        members = leaf.members.indices
        if wanted[members].any():
            value_of[members] = measure(evaluation, members)
    return value_of[asked]


def leaf_incidence(evaluation: Evaluation, members: Ints) -> float:
    """Incidence angle of a leaf's plane, degrees; NaN when it has no plane."""
    from app.core.planes import leaf_plane

    state = evaluation.subject.state
    scanner = state.scan.scanner("the angle of a leaf")
    living = members[state.alive[members]]
    try:
        plane = leaf_plane(state.scan.xyz[living], scanner, state.parameters.plane_gate)
    except BadInput:
        return float("nan")  # fewer than three points, or all on a line: no plane, no angle
    return float(to_degrees(plane.incidence))


ANGLES = (
    FieldSpec(
        "incidence",
        "Incidence angle",
        "°",
        "angle",
        compute_incidence,
        parameters=("radius", "estimator"),
        needs=("points", "pose"),
    ),
    FieldSpec(
        "incidence_sigma",
        "σ of the incidence angle",
        "°",
        "scalar",
        compute_incidence_sigma,
        ("incidence",),
        needs=("points", "pose"),
    ),
    FieldSpec(
        "incidence_width",
        "Window half-width",
        "mm",
        "scalar",
        compute_incidence_width,
        ("incidence",),
        needs=("points", "pose"),
    ),
    FieldSpec(
        "delta_omega",
        "Δω: intensity − plane",
        "°",
        "signed angle",
        compute_delta_omega,
        ("incidence_from_intensity",),
        ("plane_gate",),
        ("points", "pose", "deleted", "leaves"),
    ),
)
