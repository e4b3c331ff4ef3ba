"""Ghost points as fields: the score, the verdict, and why, and where a ghost belongs."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.footprint import BeamShape
from app.core.progress import QUIET, Progress
from app.core.units import to_mm
from app.model.fields import Computed, Evaluation, FieldSpec, Need, pick_rows
from app.model.ghost_image import ghost_image_of
from app.model.neighbours import neighbours_of
from app.model.state import ScanState

ASSUMED = "FARO LS880, since nobody told the beam of this scanner"
LEAST_LIGHT = 1e-6
"""Of the largest: darker points have no logarithm worth its name."""


def compute_ghost_score(evaluation: Evaluation, points: Ints | None) -> Computed:
    """How much a point looks like a mixed pixel, 0 to 1."""
    from app.core.ghosts import score_ghosts

    state = evaluation.subject.state
    neighbours = neighbours_of(state.scan, evaluation.progress.part(0.0, 0.3))
    beam = state.parameters.beam
    found = score_ghosts(
        state.scan.xyz,
        state.scan.scanner("the ghost score"),
        points,
        beam=shape_of_beam(state),
        light=light_of(state),
        image=ghost_image_of(state.scan),
        progress=evaluation.progress.part(0.3, 1.0),
    )
    notes = {"neighbours": neighbours.method, "method": found.method}
    notes |= {"beam": ASSUMED if beam is None else beam.origin}
    return Computed(found.score, notes | {"looked_at": found.looked})


def shape_of_beam(state: ScanState) -> BeamShape | None:
    """The beam of the scan's parameters; None where nobody told it."""
    beam = state.parameters.beam
    return None if beam is None else BeamShape(beam.radius, beam.half_divergence)


def light_of(state: ScanState) -> Floats | None:
    """Intensity of the file's first channel, as a logarithm where it is proportional to power."""
    channels = state.scan.channels
    if not channels:
        return None
    values = state.scan.channel_values(channels[0].name)
    return take_logarithm(values) if is_linear(state) else np.asarray(values, np.float64)


def is_linear(state: ScanState) -> bool:
    """Whether the light is the natural logarithm of something proportional to power."""
    channels = state.scan.channels
    return bool(channels) and channels[0].kind in ("linear", "reflectance")


def take_logarithm(values: AnyArray) -> Floats:
    """Natural logarithm; NaN where there is no light."""
    light = np.asarray(values, np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        least = LEAST_LIGHT * np.nanmax(np.where(np.isfinite(light), light, np.nan), initial=0.0)
        return np.log(np.where(light > least, light, np.nan))


def compute_ghost(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Whether a point counts as a ghost: the user's judgement, else the score (1 or 0)."""
    state = evaluation.subject.state
    score = evaluation.read("ghost_score", points)
    marks = pick_rows(state.marks, points)
    flag = (score >= state.parameters.ghost_threshold) & (marks >= 0) | (marks > 0)
    return Computed(flag.astype(np.float64))


def judged_score(state: ScanState, score: Floats) -> Floats:
    """The score of all points where the user's word, and the points deleted, count.

    A deleted point supports no surface, as a ghost does not.
    """
    judged = np.where(state.marks > 0, 1.0, np.where(state.marks < 0, 0.0, score))
    return np.where(state.deleted, 1.0, judged)


def find_corrections(
    state: ScanState, ghosts: Ints, score: Floats, progress: Progress = QUIET
) -> tuple[Floats, Floats]:
    """How far ghosts are to be moved along their beams, metres, and the confidence; (g,) each.

    `score` is the `judged_score` of all points.
    """
    from app.core.ghosts import correct_ghosts

    if not len(ghosts):
        return np.empty(0), np.empty(0)
    scanner = state.scan.scanner("the correction of ghosts")
    image = ghost_image_of(state.scan, progress)
    # Below the threshold: no point that counts as a ghost supports a surface.
    clean = float(np.nextafter(state.parameters.ghost_threshold, -1.0))
    found = correct_ghosts(
        state.scan.xyz,
        scanner,
        ghosts,
        score,
        beam=shape_of_beam(state),
        light=light_of(state),
        image=image,
        clean=clean,
        progress=progress,
    )
    own = np.linalg.norm(state.scan.xyz[ghosts] - scanner, axis=1)
    return found.ranges - own, found.confidence


def compute_correction(evaluation: Evaluation, points: Ints | None) -> Computed:
    """How far a ghost is to be moved along its beam, mm; NaN for other points.

    Its confidence lies beside it.
    """
    state = evaluation.subject.state
    rows = np.arange(evaluation.size) if points is None else points
    is_ghost = evaluation.read("ghost", points) == 1.0
    shift, confidence = np.full(len(rows), np.nan), np.full(len(rows), np.nan)
    if is_ghost.any():
        score = judged_score(state, evaluation.read("ghost_score"))
        metres, confidence[is_ghost] = find_corrections(
            state, rows[is_ghost], score, evaluation.progress
        )
        shift[is_ghost] = to_mm(metres)
    return Computed(shift, beside={"confidence": confidence})


def compute_confidence(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Probability that a ghost, put back, lies within 2 σ of the surface that owns it."""
    return Computed(evaluation.read_beside("ghost_correction", "confidence", points))


def compute_reason(evaluation: Evaluation, points: Ints | None) -> Computed:
    """What a point is, a class of `app.core.ghosts.Reason`; NaN without rows and columns."""
    from app.core.ghosts import explain_points

    state = evaluation.subject.state
    rows = np.arange(evaluation.size) if points is None else points
    reason = np.full(len(rows), np.nan)
    image = ghost_image_of(state.scan, evaluation.progress)
    if image is None:
        return Computed(reason, {"reason": "the scan has no rows and columns that are of use"})
    # What counts as a ghost is explained as one, whatever its score and the threshold are.
    called = evaluation.read("ghost") == 1.0
    score = np.where(called, 1.0, judged_score(state, evaluation.read("ghost_score")))
    ghost = pick_rows(called, points)
    reason[np.isfinite(image.own[rows])] = 0.0
    found = explain_points(
        image, rows[ghost], score, beam=shape_of_beam(state), progress=evaluation.progress
    )
    reason[ghost] = found.reason
    return Computed(reason)


_NEEDS: tuple[Need, ...] = ("points", "pose", "channels")
_ALL: tuple[Need, ...] = ("points", "pose", "channels", "marks", "deleted")

GHOSTS = (
    FieldSpec(
        "ghost_score",
        "Ghost score",
        "",
        "score",
        compute_ghost_score,
        parameters=("beam",),
        needs=_NEEDS,
    ),
    FieldSpec(
        "ghost",
        "Ghost",
        "",
        "flag",
        compute_ghost,
        ("ghost_score",),
        ("ghost_threshold",),
        ("marks",),
    ),
    FieldSpec(
        "ghost_reason",
        "Why a ghost",
        "",
        "class",
        compute_reason,
        ("ghost_score", "ghost"),
        needs=_ALL,
    ),
    FieldSpec(
        "ghost_correction",
        "Correction of ghosts",
        "mm",
        "signed",
        compute_correction,
        ("ghost_score", "ghost"),
        ("beam",),
        _ALL,
    ),
    FieldSpec(
        "ghost_confidence",
        "Confidence of the correction",
        "",
        "score",
        compute_confidence,
        ("ghost_correction",),
    ),
)
