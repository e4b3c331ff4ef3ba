"""Samples that several instruments scanned: their means, and indices of the means.

Rows are samples (leaves, or whole scans). The scans share no points, so nothing is paired point by
point unless asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.indices import NAMED, NamedIndex, match_channels, warn_about_kinds
from app.core.progress import QUIET, Progress
from app.core.radiometry.partial_hits import FULL_HIT
from app.core.sample_means import pair_nearest
from app.model.project import Project
from app.services.beams import propose_beam
from app.services.leaves import Row, find_leaves, leaves_from_labels, write_table
from app.services.opening import Opening, open_into, set_parameters
from app.services.radiometry import tell_calibration
from app.services.sample_rows import Column, Sample

SAME_PLACE = 0.03
"""Leaves that connectivity found in two scans are one when their centres lie so near, metres, and
are each other's nearest: the scanners see other parts of a leaf, and leaves are larger."""
WHOLE = "whole scan"


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a table of samples is to hold.

    Attributes
    ----------
    indices : tuple of str
        Names of `app.core.indices.NAMED`.
    full_hits : bool
        Leave out points that the beam hits in part (field ``hit_fraction``).
    pair_within : float or None
        Also pair the nearest points of the two scans of an index, within so many metres.
    """

    indices: tuple[str, ...] = ()
    full_hits: bool = False
    pair_within: float | None = None


@dataclass(frozen=True, slots=True)
class SampleTable:
    """Rows of samples, and what is worth telling: shares that were paired, warnings."""

    rows: list[Row]
    pairs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope sample``."""
        return {"samples": self.rows, "pairs": self.pairs, "warnings": list(self.warnings)}


def tabulate_files(
    openings: Sequence[Opening],
    out: Path,
    wanted: Wanted,
    *,
    label_field: str | None = None,
    by_leaf: bool = False,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> SampleTable:
    """Read scans of the same samples and write the table of their means as CSV.

    Parameters
    ----------
    openings : sequence of Opening
        One or more files, in one system of coordinates if leaves are found or points paired.
    out : Path
    wanted : Wanted
    label_field : str or None
        Field whose whole numbers from 0 on name the samples, the same in all scans.
    by_leaf : bool
        Find the leaves of each scan by connectivity and match them by place. Without both, each
        scan is one sample as a whole.

    Raises
    ------
    WrongUse
        A file is given twice, an index does not exist, or nothing can be paired.
    BadInput
        A scan has no samples, or no sample is in two scans.
    MissingChannel
        No scan has a channel that an index needs.
    Cancelled
    """
    from app.formats.atomic import refuse_target

    refuse_target(out, overwrite, sources=[opening.path for opening in openings])
    _check(openings, wanted, label_field, by_leaf)
    project = Project()
    keys: list[str] = []
    for number, opening in enumerate(openings):
        part = progress.part(0.6 * number / len(openings), 0.6 * (number + 1) / len(openings))
        keys += open_into(project, opening, part)
    for key in keys:
        if label_field is not None:
            leaves_from_labels(project, key, label_field)
        elif by_leaf:
            find_leaves(project, key)
        if (label_field is not None or by_leaf) and not project.state.leaves_of(key):
            raise BadInput(f"No sample was found in {project.state.scan(key).scan.name}.")
    table = tabulate_samples(project, keys, wanted, by_place=by_leaf, progress=progress)
    write_table(table.rows, out, overwrite)
    return table


def _check(
    openings: Sequence[Opening], wanted: Wanted, label_field: str | None, by_leaf: bool
) -> None:
    if not openings:
        raise WrongUse("Name the scans of the sample.")
    paths = [opening.path.resolve() for opening in openings]
    twice = [path.name for path in paths if paths.count(path) > 1]
    if twice:
        raise WrongUse(f"{twice[0]} is given twice; a scan is no second look at the sample.")
    if by_leaf and label_field is not None:
        raise WrongUse("Samples are told by a label field or found as leaves, not both.")
    for name in wanted.indices:
        if name not in NAMED:
            raise WrongUse(f"There is no index {name!r}.", f"Indices: {', '.join(NAMED)}.")
    if wanted.pair_within is not None and not wanted.indices:
        raise WrongUse("Points are paired to form an index of each pair.", "Name it with --index.")


def tabulate_samples(
    project: Project,
    scans: Sequence[str],
    wanted: Wanted,
    *,
    by_place: bool = False,
    progress: Progress = QUIET,
) -> SampleTable:
    """Table of the samples in some scans of a project; leaves of one name are one sample.

    Scans without leaves count as one sample each, the same one. With `by_place` leaves of one
    place are one sample instead.

    Raises
    ------
    BadInput, MissingChannel, WrongUse
        See `tabulate_files`.
    """
    members = _members(project, scans, by_place)
    names = list(dict.fromkeys(name for held in members.values() for name in held))
    if len(scans) > 1 and not any(sum(n in m for m in members.values()) > 1 for n in names):
        raise BadInput(
            "No sample is in more than one of the scans.",
            "Their labels differ, or they are not in one system of coordinates.",
        )
    columns = _name_columns(project, scans)
    roles = {name: _match(NAMED[name], columns) for name in wanted.indices}
    warnings = [
        warn_about_kinds(name, {c.name: c.kind for c in found}) for name, found in roles.items()
    ]
    _keep_full_hits(project, members, wanted, progress)
    rows: list[Row] = []
    counts = {name: np.zeros(3, np.int64) for name in roles}
    for number, name in enumerate(names):
        progress.report(0.7 + 0.3 * number / len(names), "Measuring samples")
        sample = Sample(project, {s: members[s][name] for s in scans if name in members[s]})
        row: Row = {"sample": name}
        for column in columns:
            row |= sample.describe(column)
        for index_name, pair in roles.items():
            row |= sample.describe_index(NAMED[index_name], *pair)
            if wanted.pair_within is not None:
                row |= sample.pair(NAMED[index_name], *pair, wanted.pair_within, counts[index_name])
        rows.append(row)
    pairs = {} if wanted.pair_within is None else _sum_up_pairs(project, roles, counts)
    for key in scans:
        warnings += tell_calibration(project, key, [column.channel for column in columns])
    return SampleTable(rows, pairs, tuple(text for text in warnings if text))


def _members(project: Project, scans: Sequence[str], by_place: bool) -> dict[str, dict[str, Ints]]:
    """Points of each sample in each scan, deleted ones left out."""
    found: dict[str, dict[str, Ints]] = {}
    for key in scans:
        state, leaves = project.state.scan(key), project.state.leaves_of(key)
        held: dict[str, list[Ints]] = {}
        for leaf in leaves:
            held.setdefault(leaf.name, []).append(leaf.members.indices)
        if not leaves:
            held[WHOLE] = [np.arange(len(state.scan))]
        rows = {name: np.unique(np.concatenate(parts)) for name, parts in held.items()}
        found[key] = {name: mine[state.alive[mine]] for name, mine in rows.items()}
    return _name_by_place(project, found) if by_place else found


def _name_by_place(
    project: Project, members: dict[str, dict[str, Ints]]
) -> dict[str, dict[str, Ints]]:
    """Leaves of later scans under the name of the first scan's leaf that is in their place."""
    scans = list(members)
    centres = {key: _centres(project, key, members[key]) for key in scans}
    named = {scans[0]: members[scans[0]]}
    first = list(members[scans[0]])
    for key in scans[1:]:
        own = list(members[key])
        pairs = pair_nearest(centres[scans[0]], centres[key], SAME_PLACE)
        known = {own[b]: first[a] for a, b in zip(pairs.first, pairs.second, strict=True)}
        named[key] = {known.get(name, name): rows for name, rows in members[key].items()}
    return named


def _centres(project: Project, scan: str, members: Mapping[str, Ints]) -> Floats:
    xyz = project.state.scan(scan).scan.xyz
    return np.array([np.nanmean(xyz[rows], axis=0) for rows in members.values()])


def _name_columns(project: Project, scans: Sequence[str]) -> list[Column]:
    """All channels of all scans; of equal names the later ones carry the scan's number."""
    columns: list[Column] = []
    for number, key in enumerate(scans, 1):
        taken, state = {column.name for column in columns}, project.state.scan(key)
        for channel in state.channels:
            name = f"{channel.name}_scan{number}" if channel.name in taken else channel.name
            ours = channel not in state.scan.channels
            columns.append(
                Column(name, key, channel.name, channel.wavelength_nm, channel.kind, ours)
            )
    if not columns:
        raise BadInput("None of the scans has a channel.", "Name one: NAME=WAVELENGTH:KIND.")
    return columns


def _match(index: NamedIndex, columns: Sequence[Column]) -> tuple[Column, Column]:
    by_name = {column.name: column for column in columns}
    roles = match_channels(index, {column.name: column.wavelength_nm for column in columns})
    first, second = (by_name[roles[role]] for role in index.roles)
    return first, second


def _keep_full_hits(
    project: Project,
    members: dict[str, dict[str, Ints]],
    wanted: Wanted,
    progress: Progress,
) -> None:
    if not wanted.full_hits:
        return
    for key, held in members.items():
        state = project.state.scan(key)
        if state.parameters.beam is None:
            set_parameters(project, key, beam=propose_beam(state.scan))
        for name, rows in held.items():
            share = project.field(key, "hit_fraction", rows, progress)
            held[name] = rows[share >= FULL_HIT]


def _sum_up_pairs(
    project: Project,
    roles: Mapping[str, tuple[Column, Column]],
    counts: Mapping[str, Ints],
) -> dict[str, dict[str, Any]]:
    """Of each index: how many pairs there were, and the share of each scan's points in them."""
    told = {}
    for name, columns in roles.items():
        *points, pairs = counts[name].tolist()
        shares = {
            project.state.scan(column.scan).scan.name: pairs / total if total else 0.0
            for column, total in zip(columns, points, strict=True)
        }
        told[name] = {"pairs": pairs, "matched_shares": shares}
    return told
