"""Which fields the current scan can be coloured by, in groups, and why some cannot."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from app.core.errors import LeafscopeError, MissingChannel
from app.core.indices import NAMED, match_channels
from app.core.radiometry.profile import ChannelCalibration
from app.model.fields import FieldSpec
from app.model.project import Project
from app.model.radiometry_fields import MARK, SIGMA, source_of
from app.model.smoothed_fields import SMOOTHED
from app.model.state import ScanState
from app.model.truth_fields import describe_truth
from app.model.wrinkle_fields import WRINKLES
from app.services.formulas import pick_channels

NOT_MEASURED = (
    "Not measured, and a session does not keep it: press Measure wrinkles in the Δω panel."
)
MEASURED = tuple(spec.name for spec in WRINKLES)
JUDGED = (
    "incidence_from_intensity",
    "delta_omega",
    *MEASURED,
    "residual",
    "ghost_score",
    "ghost",
    "leaf",
)
GEOMETRY = (
    "range",
    "incidence",
    "incidence_sigma",
    "incidence_width",
    "footprint",
    "footprint_share",
    "hit_fraction",
)
OPTIONAL = "hit_fraction"
"""What reflectance does without where it cannot be had."""
GROUPS = (
    "Channels",
    "Corrected",
    "Indices",
    "Smoothed",
    "Geometry",
    "Leaves & ghosts",
    "Truth",
    "Other",
)


@dataclass(frozen=True, slots=True)
class FieldAtHand:
    """A field of a scan: `missing` is a sentence when it cannot be had now, else empty."""

    name: str
    title: str
    unit: str
    group: str
    missing: str = ""


def list_fields(project: Project, scan: str) -> list[FieldAtHand]:
    """All fields of a scan, group by group; computes nothing."""
    state = project.state.scan(scan)
    found = [
        FieldAtHand(
            spec.name, spec.title, spec.unit, group_of(spec, state), why_not(project, scan, name)
        )
        for name, spec in project.catalogue(scan).items()
    ]
    return sorted(found, key=lambda field: GROUPS.index(field.group))


def group_of(spec: FieldSpec, state: ScanState) -> str:
    """The group that a field belongs to."""
    made = _group_of_made(spec, state)
    if made:
        return made
    if any(channel.name == spec.name for channel in state.channels):
        return "Channels"
    if find_calibration(state, spec.name) is not None:
        return "Channels"
    if spec.name in GEOMETRY:
        return "Geometry"
    if spec.name in JUDGED:
        return "Leaves & ghosts"
    return "Truth" if describe_truth(spec.name) else "Other"


def _group_of_made(spec: FieldSpec, state: ScanState) -> str:
    """The group of what is made of channels; empty for others, and for what the file holds."""
    if spec.stored:
        return ""
    if spec.name.endswith(SMOOTHED):
        return "Smoothed"
    corrected = {correction.name for correction in state.parameters.corrections}
    if spec.name.removesuffix(SIGMA).removesuffix(MARK) in corrected:
        return "Corrected"
    own = (formula.name for formula in state.parameters.formulas)
    endings = ("", *(f"_{workflow}" for workflow in state.workflows[1:]))
    indices = (name + ending for name in (*NAMED, *own) for ending in endings)
    return "Indices" if spec.name in indices else ""


def why_not(project: Project, scan: str, field: str) -> str:
    """What a field lacks, as a sentence; empty when it can be computed."""
    state, spec = project.state.scan(scan), project.catalogue(scan)[field]
    if "pose" in spec.needs and state.scan.pose is None:
        return "The scanner's position is unknown: set it in the Scan menu."
    calibration = find_calibration(state, field)
    if calibration is not None and field == calibration.name:
        return why_no_reflectance(project, scan, calibration, spec)
    if "curve" in spec.parameters:
        if not state.channels:
            return "The scan has no intensity."
        if state.parameters.curve is None:
            return "No angular curve is in use: fit one in the phase lab."
    if "beam" in spec.parameters and state.parameters.beam is None:
        return "The scanner's beam is unknown: give it under Scan ▸ Incidence angles."
    if "leaves" in spec.needs and not project.state.leaves_of(scan):
        return "There is no leaf yet: draw around one with the lasso."
    if spec.given and project.known_field(scan, field) is None:
        return NOT_MEASURED
    if not spec.inputs and not spec.stored:
        return _why_no_index(project, scan, spec.name)
    return _why_not_inputs(project, scan, spec.inputs)


def _why_no_index(project: Project, scan: str, name: str) -> str:
    """Which channel a named index or one of the user's own lacks; empty for other fields."""
    state = project.state.scan(scan)
    own = {formula.name: formula.text for formula in state.parameters.formulas}
    try:
        if name in NAMED:
            match_channels(NAMED[name], state.wavelengths)
        elif name in own:
            pick_channels(project, scan, own[name])
    except LeafscopeError as error:
        return error.what
    return ""


def why_no_reflectance(
    project: Project, scan: str, calibration: ChannelCalibration, spec: FieldSpec
) -> str:
    """What the reflectance of a channel lacks, as a sentence."""
    try:
        source_of(calibration, project.state.scan(scan))
    except MissingChannel as error:
        return error.what
    needed = [name for name in spec.inputs if name != OPTIONAL]
    return _why_not_inputs(project, scan, needed)


def _why_not_inputs(project: Project, scan: str, names: Iterable[str]) -> str:
    reasons = (why_not(project, scan, name) for name in names)
    return next((reason for reason in reasons if reason), "")


def find_calibration(state: ScanState, field: str) -> ChannelCalibration | None:
    """The calibrated channel that a field is the reflectance, σ or mark of."""
    profile = state.parameters.profile
    for each in profile.channels if profile is not None else ():
        if field in (each.name, each.name + SIGMA, each.name + MARK):
            return each
    return None
