"""What corrections would do, before they are put to use: numbers, leaves, angles, marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from msgspec.structs import replace

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.core.workflows.chain import LEAST_BRACKET, get_workflow
from app.core.workflows.marks import WORDS
from app.model.correction_fields import MARK
from app.model.corrections import Correction
from app.model.leaf import Leaf, join_members
from app.model.points import PointSet
from app.model.project import Project
from app.services.correction_doubts import doubt_correction
from app.services.corrections import (
    apply_corrections,
    published_correction,
    warn_about_source,
)
from app.services.curves import BIN, STEEPEST
from app.services.leaves import Row
from app.services.workflow_table import (
    CALIBRATED,
    Wanted,
    compare_points,
    compare_workflows,
    fit_corrections,
)

Source = Literal["together", "each", "published", "typed"]
TYPED = "typed in"
TOGETHER = "all"
"""Key of the row over all points that are looked at."""


@dataclass(frozen=True, slots=True)
class Order:
    """What is to be corrected, and where the numbers come from.

    Attributes
    ----------
    channels : tuple of str
    workflows : tuple of str
        Empty: show what is in use.
    source : {'together', 'each', 'published', 'typed'}
        One fit of all the leaves, a fit of each, Junttila's values, or `values`.
    leaves : tuple of str or None
        Keys; None: all leaves, or all points where there are none. Empty: the whole scan.
    species : str
        For published values.
    values : mapping of str to float
        For typed ones. A workflow takes those that it needs.
    least_bracket : float
    """

    channels: tuple[str, ...]
    workflows: tuple[str, ...]
    source: Source = "together"
    leaves: tuple[str, ...] | None = None
    species: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    least_bracket: float = LEAST_BRACKET


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Means per step of the incidence angle, degrees; empty steps are left out."""

    angle: Floats
    mean: Floats
    sd: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Preview:
    """Leaves under each workflow as if the corrections were in use.

    Attributes
    ----------
    made : tuple of Correction
        New ones.
    corrections : tuple of Correction
        All that would be in use.
    rows : list of Row
        Leaf × channel as `compare_workflows` gives them, after a row for all of them together,
        whose key is ``all``.
    steps : mapping of (channel, workflow) to Steps
    marks : mapping of (channel, workflow) to counts by word
    warnings : tuple of str
    """

    made: tuple[Correction, ...]
    corrections: tuple[Correction, ...]
    rows: list[Row]
    steps: Mapping[tuple[str, str], Steps]
    marks: Mapping[tuple[str, str], Mapping[str, int]]
    warnings: tuple[str, ...] = ()


def preview_workflows(
    project: Project, scan: str, order: Order, progress: Progress = QUIET
) -> Preview:
    """Correct as ordered and compare; changes the project, so give it a copy.

    Raises
    ------
    BadInput
        Nothing could be corrected.
    WrongUse, MissingChannel, MissingScanner
        See `app.services.corrections`.
    """
    made, warnings = make_corrections(project, scan, order, progress.part(0.0, 0.6))
    if order.workflows and not made:
        raise BadInput("No leaf could be corrected.", " ".join(warnings[-1:]))
    if made:
        apply_corrections(project, scan, made, instead=True)
    keys = [leaf.key for leaf in list_leaves(project, scan, order.leaves)]
    whole = _join(project, scan, keys)
    points = whole.members.indices
    rows = [
        compare_points(project, whole, channel, points) | {"leaf": TOGETHER}
        for channel in order.channels
    ]
    of_leaves = compare_workflows(project, scan, keys, progress.part(0.6, 0.9)) if keys else []
    rows += [row for row in of_leaves if row["channel"] in order.channels]
    angle = project.field(scan, "incidence", points)
    steps, marks = {}, {}
    for channel, workflow, name in _list_fields(project, scan, order.channels):
        steps[channel, workflow] = average_steps(angle, project.field(scan, name, points))
        if workflow != CALIBRATED:
            marks[channel, workflow] = _count(project.field(scan, name + MARK, points))
    used = project.state.scan(scan).parameters.corrections
    return Preview(tuple(made), used, rows, steps, marks, tuple(dict.fromkeys(warnings)))


def make_corrections(
    project: Project, scan: str, order: Order, progress: Progress = QUIET
) -> tuple[list[Correction], list[str]]:
    """The corrections of an order, and what could not be done; puts nothing to use."""
    if order.source in ("together", "each"):
        fit_to: Literal["all", "leaf"] = "all" if order.source == "together" else "leaf"
        wanted = Wanted(order.channels, order.workflows, fit_to, order.least_bracket, order.leaves)
        return fit_corrections(project, scan, wanted, progress) if order.workflows else ([], [])
    state = project.state.scan(scan)
    channels = [state.channel(name) for name in order.channels]
    made = []
    for channel in channels:
        for workflow in order.workflows:
            if order.source == "published":
                found = published_correction(channel, workflow, order.species, order.leaves or ())
                made.append(replace(found, least_bracket=order.least_bracket))
            else:
                made.append(_type_in(channel.name, workflow, order))
    doubts = [
        f"{each.source}, {each.workflow}: {' '.join(said)}"
        for each in made
        if (said := doubt_correction(each))
    ]
    return made, [*filter(None, map(warn_about_source, channels)), *doubts]


def _type_in(channel: str, workflow: str, order: Order) -> Correction:
    """Typed numbers: b is that of WF2, since the diffuse part of WF3 is Lambertian."""
    chain = get_workflow(workflow)
    wanted = [name for name in chain.parameters if name not in chain.assumed]
    values = {name: order.values[name] for name in wanted if name in order.values}
    return Correction(
        channel, workflow, values, {}, order.least_bracket, origin=TYPED,
        leaves=tuple(order.leaves or ()),
    )  # fmt: skip


def list_leaves(project: Project, scan: str, keys: Sequence[str] | None) -> list[Leaf]:
    """Leaves of these keys; None: all of the scan."""
    leaves = project.state.leaves_of(scan)
    return [leaf for leaf in leaves if keys is None or leaf.key in keys]


def _join(project: Project, scan: str, keys: Sequence[str]) -> Leaf:
    """All leaves as one, or the whole scan; points that exist for the user."""
    state = project.state.scan(scan)
    members = np.flatnonzero(state.alive)
    if keys:
        joined = join_members([project.state.leaves[key] for key in keys], len(state.scan))
        members = joined[state.alive[joined]]
    name = "all leaves" if keys else "whole scan"
    return Leaf("leaf-00000", scan, name, PointSet(members))


def _list_fields(
    project: Project, scan: str, channels: Sequence[str]
) -> list[tuple[str, str, str]]:
    """Channel, workflow and field of each, WF1 first."""
    there = {channel.name: channel.workflow for channel in project.state.scan(scan).channels}
    found = []
    for channel in channels:
        found.append((channel, CALIBRATED, channel))
        for name, workflow in there.items():
            if workflow and name == f"{channel}_{workflow}":
                found.append((channel, workflow, name))
    return found


def _count(marks: Floats) -> dict[str, int]:
    counts = np.bincount(marks.astype(np.int64), minlength=len(WORDS))
    return {word: int(n) for word, n in zip(WORDS, counts, strict=True) if n}


def average_steps(angle: Floats, value: Floats) -> Steps:
    """Mean and standard deviation per 5° up to 80°, of what is known."""
    used = np.isfinite(angle) & np.isfinite(value) & (angle < STEEPEST)
    angle, value = angle[used], value[used]
    _, place, count = np.unique(
        (angle // BIN).astype(np.int64), return_inverse=True, return_counts=True
    )
    mean = np.bincount(place, value) / count
    square = np.bincount(place, (value - mean[place]) ** 2, len(count))
    sd = np.sqrt(square / np.maximum(count - 1, 1))
    return Steps(np.bincount(place, angle) / count, mean, sd)
