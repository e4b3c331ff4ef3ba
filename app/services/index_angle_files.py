"""Where angles and channels come from: leaves of a scan, or a table of holder angles."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import Ints
from app.core.channel_index import ChannelIndex, choose_index
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.model.project import Project
from app.services.curves import STEEPEST
from app.services.index_angle import Group, IndexAngles, compare_angles
from app.services.leaves import find_leaves, leaves_from_labels
from app.services.opening import Opening, open_file, set_parameters
from app.services.synthetic_footprints import index_in
from app.services.table_notes import tell_missing, tell_radians
from app.services.tables import MISSING, read_table

HANCOCK_NM = 1063.0
NEAR_NM = 20.0
OF_SCAN, OF_TABLE = "fourier-2", "cosine"


def groups_of_scan(
    project: Project,
    scan: str,
    index: ChannelIndex,
    leaves: Sequence[str] | None = None,
    progress: Progress = QUIET,
) -> list[Group]:
    """Angles of incidence and channels of each leaf of a scan, up to 80°.

    Parameters
    ----------
    leaves : sequence of str or None
        Keys; None: all leaves of the scan, each on its own.
    """
    state, groups = project.state.scan(scan), []
    for leaf in project.state.leaves_of(scan):
        if leaves is not None and leaf.key not in leaves:
            continue
        points = leaf.members.indices[state.alive[leaf.members.indices]]
        groups.append(_group_points(project, scan, index, points, leaf.name, progress))
    return groups


def _group_points(
    project: Project,
    scan: str,
    index: ChannelIndex,
    points: Ints,
    name: str,
    progress: Progress,
) -> Group:
    angle = project.field(scan, "incidence", points, progress)
    values = {c: project.field(scan, c, points) for c in index.channels}
    kept = angle <= STEEPEST
    values = {channel: value[kept] for channel, value in values.items()}
    unknown = int(np.count_nonzero(np.isnan(angle)))
    steep = len(angle) - unknown - int(np.count_nonzero(kept))
    return Group({"leaf": name}, to_radians(angle[kept]), values, unknown, steep)


def group_of_scan(
    project: Project, scan: str, index: ChannelIndex, progress: Progress = QUIET
) -> Group:
    """Angles of incidence and channels of all points of a scan, up to 80°."""
    points = np.flatnonzero(project.state.scan(scan).alive)
    return _group_points(project, scan, index, points, "whole scan", progress)


def join_groups(groups: Sequence[Group]) -> Group:
    """One group of all, where single leaves hold too few angles."""
    names = groups[0].values if groups else {}
    angle = np.concatenate([group.angle for group in groups])
    values = {name: np.concatenate([group.values[name] for group in groups]) for name in names}
    unknown = sum(group.without_angle for group in groups)
    return Group({"leaf": "all"}, angle, values, unknown, sum(group.beyond for group in groups))


def index_angle_of_file(
    opening: Opening,
    index: str,
    *,
    label_field: str | None = None,
    together: bool = False,
    model: str = OF_SCAN,
    parameters: Mapping[str, Any] | None = None,
    progress: Progress = QUIET,
) -> IndexAngles:
    """Index against the angle of incidence, of the leaves of a file.

    Parameters
    ----------
    opening : Opening
    index : str
        A name or a formula.
    label_field : str or None
        Field whose whole numbers from 0 on name the leaves; None finds them by connectivity.
    together : bool
        All leaves as one: flat leaves hold one angle each.
    model : str
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.

    Raises
    ------
    BadInput
        No leaf was found.
    MissingChannel, MissingScanner, WrongUse
    """
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    if len(keys) > 1:
        raise WrongUse(f"{opening.path.name} holds {len(keys)} scans; an index is of one.")
    (scan,) = keys
    set_parameters(project, scan, **(parameters or {}))
    chosen = index_in(project, scan, index)
    if label_field is None:
        find_leaves(project, scan, progress.part(0.4, 0.7))
    else:
        leaves_from_labels(project, scan, label_field)
    groups = groups_of_scan(project, scan, chosen, None, progress.part(0.7, 0.8))
    if not groups:
        raise BadInput(f"No leaf was found in {opening.path.name}.")
    wanted = [join_groups(groups)] if together else groups
    later = progress.part(0.8, 1.0)
    return compare_angles(chosen, wanted, model, None, holder=False, progress=later)


def index_angle_of_table(
    path: Path,
    index: str,
    angle: str,
    channels: Sequence[str],
    *,
    group: Sequence[str] = (),
    model: str = OF_TABLE,
) -> IndexAngles:
    """Index against the holder angle, from a table of leaves × angles × channels.

    Parameters
    ----------
    path : Path
        CSV.
    index : str
        A name or a formula.
    angle : str
        Column of the holder angle, degrees.
    channels : sequence of str
        Columns of the channels, ``NAME`` with its nm at the end or ``NAME=NM``. The one nearest to
        1063 nm, within 20, gives the angle of the peak.
    group : sequence of str
        Columns that tell the leaves apart.
    model : str

    Raises
    ------
    WrongUse
        A column that says no wavelength.
    BadInput, MissingChannel
    """
    wavelengths = dict(map(_parse_column, channels))
    chosen = choose_index(index, wavelengths)
    table = read_table(path, (angle, *wavelengths, *group))
    degrees = table.numbers(angle, MISSING)
    angles = to_radians(degrees)
    values = {name: table.numbers(name, MISSING) for name in wavelengths}
    notes = (*tell_missing(table.name, {angle: degrees} | values), *tell_radians(angle, degrees))
    rows: dict[tuple[str, ...], list[int]] = {}
    for row in range(len(table)):
        rows.setdefault(tuple(table.columns[name][row] for name in group), []).append(row)
    groups = [
        Group(
            dict(zip(group, label, strict=True)),
            angles[chosen_rows],
            {name: value[chosen_rows] for name, value in values.items()},
        )
        for label, chosen_rows in rows.items()
    ]
    near = {name: abs(nm - HANCOCK_NM) for name, nm in wavelengths.items()}
    reference = min(near, key=lambda name: near[name])
    usable = reference if near[reference] <= NEAR_NM else None
    found = compare_angles(chosen, groups, model, usable, holder=True)
    return replace(found, warnings=(*notes, *found.warnings))


def _parse_column(text: str) -> tuple[str, float]:
    name, equals, nm = text.partition("=")
    said = re.search(r"(\d+(?:\.\d+)?)(?:\D*)$", nm if equals else name)
    if not said:
        raise WrongUse(f"{text!r} says no wavelength.", "Write NAME=NM, e.g. reflectance=1063.")
    return name, float(said[1])
