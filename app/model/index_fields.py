"""Indices as fields: the named ones and a user's own, over channels of one kind of treatment.

A family is a set of channels that were treated alike: as they are, corrected by one workflow, or
averaged over a synthetic footprint. An index takes all of its channels from one family, and its
name says which: ``ndi``, ``ndi_wf2``, ``ndi_wf2_smoothed``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from app.core.arrays import Ints
from app.core.errors import LeafscopeError, MissingChannel
from app.core.formula_wavelengths import Resolved, resolve_formula
from app.core.indices import NAMED, NamedIndex, match_channels
from app.core.indices import evaluate as evaluate_index
from app.core.workflows.chain import WORKFLOWS
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.parameters import Formula
from app.model.scan import Channel
from app.model.smoothed_fields import SMOOTHED


@dataclass(frozen=True, slots=True)
class Family:
    """Channels that were treated alike.

    Attributes
    ----------
    suffix : str
        Of the names of its indices.
    title : str
        How its channels were treated, in words; empty for those as they are.
    fields : mapping of str to str
        Field of each channel by the name that a formula has for it.
    wavelengths : mapping of str to float or None
        Nm by the same names, of those that a wavelength may stand for.
    """

    suffix: str
    title: str
    fields: Mapping[str, str]
    wavelengths: Mapping[str, float | None]


def list_families(channels: Sequence[Channel], smoothing: bool) -> list[Family]:
    """Families of channels: those as they are come first, and may be empty."""
    families = []
    for workflow in dict.fromkeys(("", *(channel.workflow for channel in channels))):
        own = {c.name: c.wavelength_nm for c in channels if c.workflow == workflow}
        # A formula that names a channel means that one, however it was treated.
        named = own if workflow else [channel.name for channel in channels]
        suffix = f"_{workflow}" if workflow else ""
        title = WORKFLOWS[workflow].title.partition(",")[0] if workflow else ""
        families.append(Family(suffix, title, {name: name for name in named}, own))
    if not smoothing:
        return families
    return families + [
        Family(
            family.suffix + SMOOTHED,
            f"{family.title}, smoothed" if family.title else "smoothed",
            {name: name + SMOOTHED for name in family.fields},
            family.wavelengths,
        )
        for family in families
    ]


def named_index_fields(families: Iterable[Family]) -> Iterator[FieldSpec]:
    """The named indices of each family; of channels as they are also those that lack one."""
    for family in families:
        for index in NAMED.values():
            field = index_field(index, family)
            if field.inputs or not family.suffix:
                yield field


def formula_fields(formulas: Iterable[Formula], families: Sequence[Family]) -> Iterator[FieldSpec]:
    """A user's formulas over each family; those that cannot be are left out but of the first."""
    for formula in formulas:
        for family in families:
            field = formula_field(formula, family)
            if field.inputs or not family.suffix:
                yield field


def index_field(index: NamedIndex, family: Family) -> FieldSpec:
    """A named spectral index over the nearest channels of a family."""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        roles = match_channels(index, family.wavelengths)
        values = {
            role: evaluation.read(family.fields[name], points) for role, name in roles.items()
        }
        told = {role: family.fields[name] for role, name in roles.items()}
        return Computed(evaluate_index(index, values), {"channels": told})

    try:
        roles = match_channels(index, family.wavelengths)
    except MissingChannel:
        roles = {}
    inputs = tuple(dict.fromkeys(family.fields[name] for name in roles.values()))
    return FieldSpec(
        index.name + family.suffix, _title(index.title, family), "", "scalar", compute, inputs
    )


def formula_field(formula: Formula, family: Family) -> FieldSpec:
    """A user's own formula over channels, by name or by wavelength; the choice is noted."""

    def resolve() -> Resolved:
        return resolve_formula(formula.text, family.wavelengths, family.fields)

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        found = resolve()
        values = {
            name: evaluation.read(family.fields[name], points) for name in found.reads.values()
        }
        notes = {pick.symbol: pick.words for pick in found.picks}
        return Computed(found.evaluate(values), notes)

    try:
        names = dict.fromkeys(resolve().reads.values())
        inputs = tuple(family.fields[name] for name in names)
    except LeafscopeError:
        inputs = ()
    title = _title(f"{formula.name} = {formula.text}", family)
    return FieldSpec(formula.name + family.suffix, title, "", "scalar", compute, inputs)


def _title(title: str, family: Family) -> str:
    return f"{title} ({family.title})" if family.title else title
