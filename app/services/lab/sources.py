"""Where the pairs of a command come from: columns of a table, or leaves × channels of a scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.model.project import Project
from app.services.fit import group_rows
from app.services.lab.fit_table import CHANNEL, SAMPLE, SampleLeaves, each_leaf, read_angles
from app.services.lab.gather import gather
from app.services.lab.orders import PairGroup
from app.services.leaves import find_leaves, leaves_from_labels
from app.services.opening import Opening, open_file, set_parameters
from app.services.table_notes import tell_missing, tell_radians
from app.services.tables import MISSING, read_table

Leaves = Literal["each", "together", "scan"]
TOGETHER, WHOLE = "all leaves", "whole scan"


def groups_of_table(
    path: Path, x: str, y: str, group: Sequence[str] = (), leaf: str | None = None
) -> list[PairGroup]:
    """The groups of a table, in the order in which they appear.

    Parameters
    ----------
    x, y : str
        Columns of the angle, degrees, and of the value.
    group : sequence of str
        Rows that agree in these columns belong together.
    leaf : str, optional
        Column that tells leaves apart, for a bootstrap.

    Raises
    ------
    BadInput
        The table cannot be read, lacks a column or has a cell that is not a number; a column
        holds no number at all.
    """
    own = (leaf,) if leaf is not None else ()
    table = read_table(path, (x, y, *group, *own))
    angle, value = table.numbers(x, MISSING), table.numbers(y, MISSING)
    for name, numbers in ((x, angle), (y, value)):
        if not np.isfinite(numbers).any():
            raise BadInput(f"{table.name} holds no number in column {name!r}.")
    number = np.unique(table.columns[leaf], return_inverse=True)[1] if leaf is not None else None
    notes = (*tell_missing(table.name, {x: angle, y: value}), *tell_radians(x, angle))
    none = np.empty(0, np.int64)
    return [
        PairGroup(
            dict(zip(group, label, strict=True)), angle[rows], value[rows],
            none if number is None else number[rows], notes,
        )
        for label, rows in group_rows(table, group).items()
    ]  # fmt: skip


@dataclass(frozen=True, slots=True)
class ScanOrder:
    """Which leaves and channels of a scan.

    Attributes
    ----------
    channels : tuple of str
        Empty: all that are not corrected for the angle.
    leaves : {'each', 'together', 'scan'}
        Each leaf is a sample, all leaves are one, or the whole scan is.
    label_field : str or None
        Field whose whole numbers from 0 on name the leaves; None finds them by connectivity.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    """

    channels: tuple[str, ...] = ()
    leaves: Leaves = "each"
    label_field: str | None = None
    parameters: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ScanPairs:
    """Pairs of samples × channels, and what the values are, with their unit."""

    groups: list[PairGroup]
    value_title: str


def pairs_of_scan(opening: Opening, order: ScanOrder, progress: Progress = QUIET) -> ScanPairs:
    """Read a scan, find its leaves, and gather samples × channels.

    Raises
    ------
    BadInput
        No leaf was found, or the file cannot be read.
    WrongUse
        Leaves are named by labels and not wanted.
    MissingChannel, MissingScanner
    """
    if order.leaves == "scan" and order.label_field is not None:
        raise WrongUse("Labels name leaves, and the whole scan is wanted.", "Leave one of them.")
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    groups: list[PairGroup] = []
    titles: dict[str, None] = {}
    for number, key in enumerate(keys):
        part = progress.part(0.4 + 0.6 * number / len(keys), 0.4 + 0.6 * (number + 1) / len(keys))
        set_parameters(project, key, **(order.parameters or {}))
        samples = _find_samples(project, key, order, part.part(0.0, 0.4))
        channels = _find_channels(project, key, order.channels, titles)
        read_angles(project, key, samples, part.part(0.4, 1.0))
        name = {"scan": project.state.scan(key).scan.name} if len(keys) > 1 else {}
        for sample in samples:
            for channel in channels:
                measured = gather(project, key, sample.leaves, channel)
                labels = name | {SAMPLE: sample.name, CHANNEL: channel}
                groups.append(PairGroup(labels, measured.angle, measured.value, measured.leaf))
    return ScanPairs(groups, next(iter(titles)) if len(titles) == 1 else "Value")


def _find_samples(
    project: Project, scan: str, order: ScanOrder, progress: Progress
) -> tuple[SampleLeaves, ...]:
    if order.leaves == "scan":
        return (SampleLeaves(WHOLE),)
    if order.label_field is not None:
        leaves_from_labels(project, scan, order.label_field)
    else:
        find_leaves(project, scan, progress)
    samples = each_leaf(project, scan)
    if not samples:
        raise BadInput(f"No leaf was found in {project.state.scan(scan).scan.name}.")
    if order.leaves == "each":
        return samples
    return (SampleLeaves(TOGETHER, tuple(key for s in samples for key in s.leaves)),)


KINDS = {
    "DN": "Intensity (DN)", "dB": "Intensity (dB)", "linear": "Intensity (linear)",
    "reflectance": "Reflectance (0–1)",
}  # fmt: skip


def _find_channels(
    project: Project, scan: str, wanted: Sequence[str], titles: dict[str, None]
) -> list[str]:
    state = project.state.scan(scan)
    names = list(wanted) or [c.name for c in state.channels if not c.workflow]
    if not names:
        names = [state.channel_in_use("a fit").name]
    titles.update(dict.fromkeys(KINDS[state.channel(name).kind] for name in names))
    return names
