"""Corrected channels as fields: their values, how sure they are, why some are missing."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.units import to_radians
from app.core.workflows.chain import Corrected, correct, get_workflow
from app.core.workflows.marks import GOOD, NO_CORRECTION, WORDS
from app.model.corrections import Correction, group_corrections
from app.model.fields import Computed, Evaluation, FieldSpec, Need
from app.model.scan import Channel

SIGMA, MARK = "_sigma", "_mark"
Group = tuple[Correction, ...]


def correction_fields(
    corrections: Sequence[Correction],
    channels: Sequence[Channel],
    units: dict[str, str],
    there: Collection[str],
) -> list[FieldSpec]:
    """Three fields per corrected channel: its values, their σ, and the mark.

    Parameters
    ----------
    corrections : sequence of Correction
    channels : sequence of Channel
        That may be corrected.
    units : dict of str to str
        Unit of each kind of channel.
    there : collection of str
        Names of the other fields: which of the channels have a σ of their own.
    """
    by_name = {channel.name: channel for channel in channels}
    specs: list[FieldSpec] = []
    for name, group in group_corrections(corrections, channels).items():
        specs += _fields_of(name, group, by_name[group[0].source], units, there)
    return specs


def _fields_of(
    name: str, group: Group, source: Channel, units: dict[str, str], there: Collection[str]
) -> list[FieldSpec]:
    sigma_field = source.name + SIGMA if source.name + SIGMA in there else ""

    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        return compute_corrected(group, evaluation, points)

    def sigma(evaluation: Evaluation, points: Ints | None) -> Computed:
        return compute_sigma(group, source, sigma_field, evaluation, points)

    def mark(evaluation: Evaluation, points: Ints | None) -> Computed:
        return Computed(evaluation.read_beside(name, "mark", points).astype(np.float64))

    needs: tuple[Need, ...] = ("leaves",) if any(each.leaves for each in group) else ()
    chain, unit = get_workflow(group[0].workflow), units[source.kind]
    title, short = f"{source.name}, {chain.title}", chain.title.partition(",")[0]
    whose = "" if sigma_field or source.sigma is not None else ", of angle and fit only"
    inputs = (name, "incidence_sigma", *((sigma_field,) if sigma_field else ()))
    return [
        FieldSpec(
            name, title, unit, "scalar", compute, (source.name, "incidence"), (), needs,
            made_with=group,
        ),
        FieldSpec(
            name + SIGMA, f"σ of {source.name}, {short}{whose}", unit, "scalar", sigma, inputs
        ),
        FieldSpec(name + MARK, f"Mark of {source.name}, {short}", "", "correction", mark, (name,)),
    ]  # fmt: skip


def compute_corrected(group: Group, evaluation: Evaluation, points: Ints | None) -> Computed:
    """Corrected values; NaN with a mark beside where there is none."""
    intensity, angle = _measured(group, evaluation, points)
    values = np.full(len(intensity), np.nan)
    marks = np.full(len(intensity), NO_CORRECTION, np.uint8)
    for rows, correction in _share_out(group, evaluation, points):
        found = _correct(correction, intensity[rows], angle[rows])
        values[rows], marks[rows] = found.values, found.marks
    counts = np.bincount(marks, minlength=len(WORDS))
    notes: dict[str, object] = {word: int(n) for word, n in zip(WORDS, counts, strict=True) if n}
    notes |= {"marked": int((marks != GOOD).sum()), "least bracket": group[0].least_bracket}
    notes |= {"origin": group[0].origin if len(group) == 1 else f"{len(group)} corrections"}
    return Computed(values, notes, beside={"mark": marks})


def compute_sigma(
    group: Group,
    source: Channel,
    sigma_field: str,
    evaluation: Evaluation,
    points: Ints | None,
) -> Computed:
    """σ of corrected values: of the channel, times the factor, of the angle, and of the fit.

    Where the channel's own σ is unknown it is left out, and the field's title says so. NaN where
    the σ of the angle cannot be told.
    """
    intensity, angle = _measured(group, evaluation, points)
    of_angle = to_radians(evaluation.read("incidence_sigma", points))
    own: Floats = np.full(len(intensity), source.sigma or 0.0)
    if sigma_field:
        own = evaluation.read(sigma_field, points)
    sigma = np.full(len(intensity), np.nan)
    for rows, correction in _share_out(group, evaluation, points):
        found = _correct(correction, intensity[rows], angle[rows])
        sigma[rows] = found.sigma(own[rows], of_angle[rows], correction.covariance)
    return Computed(sigma)


def _measured(group: Group, evaluation: Evaluation, points: Ints | None) -> tuple[Floats, Floats]:
    """Values of the source, and incidence angles in radians."""
    angle = to_radians(evaluation.read("incidence", points))
    return evaluation.read(group[0].source, points), angle


def _correct(correction: Correction, intensity: Floats, angle: Floats) -> Corrected:
    return correct(correction.workflow, intensity, angle, correction.values, correction.limits)


def _share_out(
    group: Group, evaluation: Evaluation, points: Ints | None
) -> Iterator[tuple[AnyArray, Correction]]:
    """Each correction with the rows, among those asked for, that it is for."""
    of_all = [number for number, each in enumerate(group) if not each.leaves]
    which = np.full(evaluation.size, of_all[-1] if of_all else -1, np.int64)
    of_leaf = {key: number for number, each in enumerate(group) for key in each.leaves}
    for leaf in evaluation.subject.leaves:
        if leaf.key in of_leaf:
            which[leaf.members.indices] = of_leaf[leaf.key]
    asked = which if points is None else which[points]
    for number, correction in enumerate(group):
        rows = np.flatnonzero(asked == number)
        if len(rows):
            yield rows, correction
