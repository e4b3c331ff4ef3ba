"""The share of the beam on a point's own surface, as a field."""

from __future__ import annotations

from app.core.arrays import Ints
from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.core.radiometry.partial_hits import FULL_HIT, hit_fraction
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.footprint_fields import beam_in_use
from app.model.neighbours import neighbours_of
from app.model.state import ScanState


def compute_hit_fraction(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Share of the beam on the surface of its own point, 0 to 1; needs rows and columns."""
    beam = beam_in_use(evaluation)
    scan = evaluation.subject.state.scan
    scanner = scan.scanner("the share of a beam on its surface")
    neighbours = neighbours_of(scan, evaluation.progress)
    if neighbours.grid is None:
        raise BadInput(
            f"{scan.name}: the share of a beam on its surface needs rows and columns, and there "
            f"are none: {neighbours.reason}.",
            "Open the scan in a format that keeps them, such as PTX or E57.",
        )
    values = hit_fraction(
        scan.xyz, scanner, neighbours.grid, beam.radius, beam.half_divergence, points,
        evaluation.progress,
    )  # fmt: skip
    notes = {"neighbours": neighbours.method, "beam": beam.origin, "full_hit_from": FULL_HIT}
    return Computed(values, notes)


def find_missing(state: ScanState, progress: Progress = QUIET) -> str:
    """What a scan lacks for this field, in words; empty when it can be computed."""
    if state.parameters.beam is None:
        return "the beam is unknown"
    if state.scan.pose is None:
        return "the scanner's position is unknown"
    if neighbours_of(state.scan, progress).grid is None:
        return "the scan has no rows and columns"
    return ""


HITS = (
    FieldSpec(
        "hit_fraction",
        "Share of the beam on the surface",
        "",
        "scalar",
        compute_hit_fraction,
        parameters=("beam",),
        needs=("points", "pose"),
    ),
)
