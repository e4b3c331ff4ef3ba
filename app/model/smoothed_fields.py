"""Channels averaged over a synthetic footprint, as fields: what a wider beam would have seen."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Ints
from app.core.synthetic_footprint import smooth
from app.core.units import to_mm
from app.model.fields import Computed, Evaluation, FieldSpec
from app.model.neighbours import neighbours_of
from app.model.scan import Channel

SMOOTHED = "_smoothed"


def smoothed_fields(channels: tuple[Channel, ...], units: dict[str, str]) -> list[FieldSpec]:
    """One field per channel, at the size that the scan's parameters say."""
    return [_field_of(channel, units[channel.kind]) for channel in channels]


def _field_of(channel: Channel, unit: str) -> FieldSpec:
    def compute(evaluation: Evaluation, points: Ints | None) -> Computed:
        return compute_smoothed(channel.name, evaluation, points)

    return FieldSpec(
        channel.name + SMOOTHED,
        f"{channel.name}, smoothed",
        unit,
        "scalar",
        compute,
        (channel.name,),
        ("synthetic_footprint",),
        ("points", "pose", "deleted"),
    )


def compute_smoothed(channel: str, evaluation: Evaluation, points: Ints | None) -> Computed:
    """Mean of a channel over the points within a synthetic footprint; deleted ones left out."""
    state = evaluation.subject.state
    diameter = state.parameters.synthetic_footprint or 0.0
    scanner = state.scan.scanner("a synthetic footprint")
    neighbours = neighbours_of(state.scan, evaluation.progress)
    # All points are read, and not only those asked for: any of them may lie in a footprint.
    values = evaluation.read(channel, None)[None]
    found = smooth(
        values, state.scan.xyz, scanner, neighbours.grid, diameter, points, state.deleted,
        evaluation.progress,
    )  # fmt: skip
    notes = {
        "diameter_mm": to_mm(diameter),
        "median points": float(np.median(found.count)) if len(found.count) else None,
        "neighbours": neighbours.method,
    }
    return Computed(found.values[0], notes)
