"""Which fields a scan can have, and how each is computed. The only list of fields."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Ints
from app.model.angle_fields import ANGLES
from app.model.calibrated import calibrated_channels
from app.model.correction_fields import correction_fields
from app.model.corrections import corrected_channels
from app.model.curve_fields import curve_fields
from app.model.fields import Catalogue, Computed, Evaluation, FieldSpec, Same, pick_rows
from app.model.footprint_fields import FOOTPRINTS
from app.model.ghost_fields import GHOSTS
from app.model.hit_fields import HITS
from app.model.index_fields import formula_fields, list_families, named_index_fields
from app.model.parameters import Parameters
from app.model.radiometry_fields import reflectance_fields
from app.model.scan import Channel, Scan
from app.model.smoothed_fields import smoothed_fields
from app.model.truth_fields import TruthField, describe_truth
from app.model.waveform_fields import waveform_fields
from app.model.wrinkle_fields import WRINKLES

CHANNEL_UNITS = {"DN": "DN", "dB": "dB", "linear": "", "reflectance": ""}


def build_catalogue(scan: Scan, parameters: Parameters) -> Catalogue:
    """Fields of a scan by name: geometry, channels, reflectance, indices, formulas, the rest.

    Fields that need what the scan lacks (a scanner position, a channel) are listed all
    the same: asking for them raises the error that says what is missing.
    """
    profile = parameters.profile
    given = (*calibrated_channels(scan, profile), *scan.channels)
    specs = [*GEOMETRY, *reflectance_fields(profile, scan), *map(channel_field, scan.channels)]
    specs += waveform_fields(scan)
    names = {spec.name for spec in specs}
    specs += correction_fields(parameters.corrections, given, CHANNEL_UNITS, names)
    channels = (*given, *corrected_channels(parameters.corrections, given))
    smoothing = parameters.synthetic_footprint is not None
    specs += curve_fields(parameters.curve, channels, CHANNEL_UNITS)
    specs += smoothed_fields(channels, CHANNEL_UNITS) if smoothing else ()
    families = list_families(channels, smoothing)
    specs += named_index_fields(families)
    catalogue = {spec.name: spec for spec in specs}
    # Never in place of a field that others are computed from.
    for spec in formula_fields(parameters.formulas, families):
        catalogue.setdefault(spec.name, spec)
    for name, values in scan.attributes.items():
        if name not in catalogue and values.dtype.kind in "buif":
            catalogue[name] = attribute_field(name)
    return catalogue


def catalogue_depends_on(parameters: Parameters) -> tuple[object, ...]:
    """The parameters that say which fields there are, to be compared."""
    return (
        parameters.formulas,
        Same(parameters.profile),
        parameters.corrections,
        parameters.synthetic_footprint is not None,
        None if parameters.curve is None else parameters.curve.channel,
    )


def channel_field(channel: Channel) -> FieldSpec:
    """A channel as a field, in its own unit; nothing is rescaled."""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        values = evaluation.subject.state.scan.attributes[channel.attribute]
        return Computed(pick_rows(values, points).astype(np.float64))

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
        values = pick_rows(evaluation.subject.state.scan.attributes[name], points).astype(
            np.float64
        )
        return Computed(np.where(values < 0, np.nan, values) if shown.numbers else values)

    return FieldSpec(name, shown.title, shown.unit, shown.kind, compute, stored=True)


def compute_range(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Distance from the scanner, metres."""
    scan = evaluation.subject.state.scan
    offset = pick_rows(scan.xyz, points) - scan.scanner("the range")
    return Computed(np.sqrt(np.einsum("ij,ij->i", offset, offset)))


def compute_leaf(evaluation: Evaluation, points: Ints | None) -> Computed:
    """Number of the leaf that a point belongs to; NaN outside leaves."""
    values = np.full(evaluation.size, np.nan)
    for leaf in evaluation.subject.leaves:
        values[leaf.members.indices] = int(leaf.key.rpartition("-")[2])
    return Computed(pick_rows(values, points))


GEOMETRY = (
    FieldSpec("range", "Range", "m", "scalar", compute_range, needs=("points", "pose")),
    *ANGLES,
    *FOOTPRINTS,
    *HITS,
    *WRINKLES,
    *GHOSTS,
    FieldSpec("leaf", "Leaf", "", "class", compute_leaf, needs=("leaves",)),
)
