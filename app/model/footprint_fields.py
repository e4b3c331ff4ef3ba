"""The beam on the leaf as fields: how long its footprint is, and what share of the leaf."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Ints
from app.core.errors import BadInput
from app.core.footprint import footprint_axis, leaf_diameter
from app.core.units import to_mm, to_radians
from app.model.angle_fields import spread_over_leaves
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.parameters import Beam


def compute_footprint(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Major axis of the beam's footprint, mm (Balduzzi 2011, equation 4).

    NaN where the surface is so steep that the outer ray of the beam no longer meets it.
    """
    beam = beam_in_use(evaluation)
    distance = evaluation.read("range", points)
    incidence = to_radians(evaluation.read("incidence", points))
    axis = to_mm(footprint_axis(distance, incidence, beam.radius, beam.half_divergence))
    notes = {
        "beam": beam.origin,
        "exit_diameter_m": 2.0 * beam.radius,
        "half_divergence_rad": beam.half_divergence,
    }
    return Computed(np.where(np.isfinite(axis), axis, np.nan), notes)


def compute_footprint_share(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Footprint as a share of the leaf's size (1: as long as the leaf); NaN outside leaves.

    The size of a leaf is the diameter of the circle that has its area; see
    `app.core.footprint.leaf_diameter`.
    """
    beam_in_use(evaluation)
    asked = np.arange(evaluation.size) if points is None else points
    size = spread_over_leaves(evaluation, asked, measure_size)
    share = np.full(len(asked), np.nan)
    rows = np.flatnonzero(size > 0.0)
    if len(rows):
        share[rows] = evaluation.read("footprint", asked[rows]) / to_mm(size[rows])
    return Computed(share, {"leaves": len(evaluation.subject.leaves)})


def measure_size(evaluation: Evaluation, members: Ints) -> float:
    """Diameter of the circle with a leaf's area, metres; NaN when it has no plane."""
    from app.core.planes import leaf_plane

    state = evaluation.subject.state
    living = state.scan.xyz[members[state.alive[members]]]
    try:
        plane = leaf_plane(living, None, state.parameters.plane_gate)
    except BadInput:
        return float("nan")  # fewer than three points, or all on a line: no area
    return leaf_diameter(living, plane.normal)


def beam_in_use(evaluation: Evaluation) -> Beam:
    """The beam of the scan's parameters; raises `BadInput` where nobody told it."""
    return require_beam(evaluation.subject.state.parameters.beam)


def require_beam(beam: Beam | None) -> Beam:
    """The same beam; raises `BadInput` where there is none."""
    if beam is None:
        raise BadInput(
            "The beam of the scanner is unknown, and its footprint needs it.",
            "Give --instrument, or --exit-diameter and --half-divergence; "
            "in the window, Scan ▸ Incidence angles.",
        )
    return beam


FOOTPRINTS = (
    FieldSpec(
        "footprint",
        "Footprint, major axis",
        "mm",
        "scalar",
        compute_footprint,
        ("range", "incidence"),
        ("beam",),
        ("points", "pose"),
    ),
    FieldSpec(
        "footprint_share",
        "Footprint over leaf size",
        "",
        "scalar",
        compute_footprint_share,
        ("footprint",),
        ("plane_gate", "beam"),
        ("points", "pose", "deleted", "leaves"),
    ),
)
