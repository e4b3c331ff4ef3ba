"""Which fields a scan can have, and how each is computed. The only list of fields."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, LeafscopeError, MissingChannel
from app.core.indices import NAMED, NamedIndex, match_channels
from app.core.indices import evaluate as evaluate_index
from app.core.units import to_degrees, to_radians
from app.model.fields import Catalogue, Computed, Evaluation, FieldSpec
from app.model.parameters import Curve, Formula
from app.model.scan import Channel, Scan
from app.model.truth_fields import TruthField, describe_truth

CHANNEL_UNITS = {"DN": "DN", "dB": "dB", "linear": "", "reflectance": ""}


def build_catalogue(scan: Scan, formulas: Iterable[Formula] = ()) -> Catalogue:
    """Fields of a scan by name: geometry, channels, indices, formulas, other attributes.

    Fields that need what the scan lacks (a scanner position, a channel) are listed all
    the same: asking for them raises the error that says what is missing.
    """
    specs = [*GEOMETRY, *map(channel_field, scan.channels)]
    specs += [index_field(index, scan) for index in NAMED.values()]
    catalogue = {spec.name: spec for spec in specs}
    for formula in formulas:  # never in place of a field that others are computed from
        catalogue.setdefault(formula.name, formula_field(formula, scan))
    for name, values in scan.attributes.items():
        if name not in catalogue and values.dtype.kind in "buif":
            catalogue[name] = attribute_field(name)
    return catalogue


def channel_field(channel: Channel) -> FieldSpec:
    """A channel as a field, in its own unit; nothing is rescaled."""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        values = evaluation.subject.state.scan.attributes[channel.attribute]
        return Computed(_rows(values, points).astype(np.float64))

    nm = "" if channel.wavelength_nm is None else f"{channel.wavelength_nm:g}"
    title = channel.name if nm in channel.name else f"{channel.name} ({nm} nm)"
    return FieldSpec(
        channel.name,
        title,
        CHANNEL_UNITS[channel.kind],
        "scalar",
        compute,
        needs=("channels",),
        stored=channel.name == channel.attribute,
    )


def attribute_field(name: str) -> FieldSpec:
    """Any other number that the file holds; the truth of simulated scans under its title."""
    shown = describe_truth(name) or TruthField(name)

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        values = _rows(evaluation.subject.state.scan.attributes[name], points).astype(np.float64)
        return Computed(np.where(values < 0, np.nan, values) if shown.numbers else values)

    return FieldSpec(name, shown.title, shown.unit, shown.kind, compute, stored=True)


def index_field(index: NamedIndex, scan: Scan) -> FieldSpec:
    """A named spectral index over the nearest channels."""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        roles = match_channels(index, evaluation.subject.state.scan.wavelengths)
        values = {role: evaluation.read(name, points) for role, name in roles.items()}
        return Computed(evaluate_index(index, values), {"channels": roles})

    try:
        roles = match_channels(index, scan.wavelengths)
    except MissingChannel:
        roles = {}
    return FieldSpec(
        index.name, index.title, "", "scalar", compute, tuple(dict.fromkeys(roles.values()))
    )


def formula_field(formula: Formula, scan: Scan) -> FieldSpec:
    """A user's own formula over channels."""
    from app.core.formula import compile_formula

    channels = [channel.name for channel in scan.channels]

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        compiled = compile_formula(formula.text, channels)
        values = {name: evaluation.read(name, points) for name in compiled.names}
        return Computed(compiled.evaluate(values))

    try:
        inputs = compile_formula(formula.text, channels).names
    except LeafscopeError:
        inputs = ()
    title = f"{formula.name} = {formula.text}"
    return FieldSpec(formula.name, title, "", "scalar", compute, tuple(inputs))


def compute_range(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Distance from the scanner, metres."""
    scan = evaluation.subject.state.scan
    offset = _rows(scan.xyz, points) - scan.scanner("the range")
    return Computed(np.sqrt(np.einsum("ij,ij->i", offset, offset)))


def compute_incidence(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle between beam and local normal, degrees (Junttila 2016, 2.6.1)."""
    from app.core.incidence import incidence_angle, local_planes

    state = evaluation.subject.state
    scanner = state.scan.scanner("the incidence angle")
    planes = local_planes(
        state.scan.xyz,
        scanner,
        points,
        state.parameters.radius,
        state.scan.grid,
        evaluation.progress,
    )
    angles = incidence_angle(_rows(state.scan.xyz, points), planes.normals, scanner)
    used = planes.width[np.isfinite(angles)]
    notes = {
        "neighbours": planes.method,
        "reason": planes.reason,
        "radius_m": state.parameters.radius,
        "median_width_m": float(np.median(used)) if len(used) else None,
        "widened": int((used > state.parameters.radius * 1.0001).sum()),
    }
    return Computed(to_degrees(angles), notes, planes.seconds)


def compute_incidence_from_intensity(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle whose intensity on the fitted curve is the point's, degrees; NaN where none is."""
    from app.core.phase import get_model

    curve = _curve_in_use(evaluation)
    intensity = evaluation.read(curve.channel, points)
    angles = get_model(curve.model).inverse(intensity, curve.values, curve.within)
    return Computed(to_degrees(angles), {"curve": curve.model, "origin": curve.origin})


def compute_delta_omega(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Angle from intensity less the angle of the leaf's plane, degrees (Balduzzi 2011)."""
    asked = np.arange(evaluation.size) if points is None else points
    wanted = np.zeros(evaluation.size, bool)
    wanted[asked] = True
    angle_of = np.full(evaluation.size, np.nan)
    for leaf in evaluation.subject.leaves:
        members = leaf.members.indices
        if wanted[members].any():
            angle_of[members] = leaf_incidence(evaluation, members)
    plane_angle = angle_of[asked]
    values = np.full(len(asked), np.nan)
    rows = np.flatnonzero(np.isfinite(plane_angle))
    if len(rows):
        found = evaluation.read("incidence_from_intensity", asked[rows])
        values[rows] = found - plane_angle[rows]
    return Computed(values, {"leaves": len(evaluation.subject.leaves)})


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


def compute_ghost_score(evaluation: Evaluation, points: Ints | None) -> Computed:
    """How much a point looks like a mixed pixel, 0 to 1."""
    from app.core.ghosts import ghost_score

    state = evaluation.subject.state
    scanner = state.scan.scanner("the ghost score")
    incidence = to_radians(evaluation.read("incidence", points))
    # A logarithm of the power says nothing about how much of it is lost.
    linear = [c for c in state.scan.channels if c.kind in ("linear", "reflectance")]
    intensity = state.scan.channel_values(linear[0].name) if linear else None
    values = ghost_score(
        state.scan.xyz,
        scanner,
        points,
        state.scan.grid,
        incidence=incidence,
        intensity=intensity,
        radius=state.parameters.radius,
        progress=evaluation.progress,
    )
    return Computed(values)


def compute_ghost(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Whether a point counts as a ghost: the user's judgement, else the score (1 or 0)."""
    state = evaluation.subject.state
    score = evaluation.read("ghost_score", points)
    marks = _rows(state.marks, points)
    flag = (score >= state.parameters.ghost_threshold) & (marks >= 0) | (marks > 0)
    return Computed(flag.astype(np.float64))


def compute_leaf(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Number of the leaf that a point belongs to; NaN outside leaves."""
    values = np.full(evaluation.size, np.nan)
    for leaf in evaluation.subject.leaves:
        values[leaf.members.indices] = int(leaf.key.rpartition("-")[2])
    return Computed(_rows(values, points))


def _curve_in_use(evaluation: Evaluation) -> Curve:
    curve = evaluation.subject.state.parameters.curve
    evaluation.subject.state.channel_in_use("the angle from intensity")
    if curve is None:
        raise BadInput(
            "No angular curve is in use, and the angle from intensity needs one.",
            "Fit a leaf in the phase lab and press 'Use this curve'.",
        )
    return curve


def _rows(values: Floats, points: Ints | None) -> Floats:
    return values if points is None else values[points]


GEOMETRY = (
    FieldSpec("range", "Range", "m", "scalar", compute_range, needs=("points", "pose")),
    FieldSpec(
        "incidence",
        "Incidence angle",
        "°",
        "angle",
        compute_incidence,
        parameters=("radius",),
        needs=("points", "pose"),
    ),
    FieldSpec(
        "incidence_from_intensity",
        "Angle from intensity",
        "°",
        "angle",
        compute_incidence_from_intensity,
        parameters=("curve", "channel"),
        needs=("channels",),
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
    FieldSpec(
        "ghost_score",
        "Ghost score",
        "",
        "score",
        compute_ghost_score,
        ("incidence",),
        needs=("points", "pose", "channels"),
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
    FieldSpec("leaf", "Leaf", "", "class", compute_leaf, needs=("leaves",)),
)
