"""Leaves of a scan: found by segmentation or labels, and measured into a table."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import BadInput, MissingChannel, MissingScanner
from app.core.indices import NAMED, match_channels
from app.core.indices import evaluate as evaluate_index
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees
from app.core.workflows.marks import GOOD
from app.formats.atomic import atomic_path
from app.model.correction_fields import MARK
from app.model.leaf import Leaf, join_members
from app.model.neighbours import neighbours_of
from app.model.operations import PutLeaf, Several
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import Explicit, FieldRange, Selection
from app.model.state import ScanState, make_key, next_leaf_key
from app.services.error_budget import explain_reflectance

# A segment that shares more than this with a leaf is that leaf, seen with another border.
SAME_LEAF = 0.3
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?")
Row = dict[str, str | float | int | None]


def find_leaves(project: Project, scan: str, progress: Progress = QUIET) -> list[str]:
    """Segment a scan into leaves by connectivity, as one step; give their keys."""
    from app.core.segments import segment_leaves

    state = project.state.scan(scan)
    scanner = None if state.scan.pose is None else state.scan.scanner("segmentation")
    left_out = state.deleted
    if scanner is not None:
        left_out = left_out | (project.field(scan, "ghost", None, progress) == 1.0)
    grid = neighbours_of(state.scan, progress).grid
    labels = segment_leaves(state.scan.xyz, scanner, grid, ghosts=left_out, progress=progress)
    _leave_known_leaves(labels, [leaf.members.indices for leaf in project.state.leaves_of(scan)])
    return _put_leaves(project, scan, labels.astype(np.float64), None)


def _leave_known_leaves(labels: AnyArray, known: Sequence[Ints]) -> None:
    """Take out what the user has made a leaf already, and the rims left around it."""
    if not known or labels.max(initial=-1) < 0:
        return
    taken = np.zeros(len(labels), bool)
    for members in known:
        taken[members] = True
    found = labels >= 0
    size = np.bincount(labels[found])
    overlap = np.bincount(labels[found & taken], minlength=len(size))
    mostly = overlap > SAME_LEAF * size
    labels[taken] = -1
    labels[found & mostly[labels]] = -1


def leaves_from_labels(project: Project, scan: str, field: str) -> list[str]:
    """Make a leaf of each value of a label field that is 0 or above, as one step."""
    labels = project.field(scan, field)
    labels = np.where(project.state.scan(scan).alive, labels, -1.0)
    if (labels[np.isfinite(labels)] % 1 != 0).any():
        raise BadInput(
            f"{field} holds numbers with decimals, so it cannot be a label.",
            "Name a field of whole numbers with --label-field.",
        )
    return _put_leaves(project, scan, labels, field)


def _put_leaves(project: Project, scan: str, labels: Floats, field: str | None) -> list[str]:
    steps, keys = [], []
    first = key_number(next_leaf_key(project.state))
    for number, (label, rows) in enumerate(_groups(labels), first):
        members = PointSet(rows)
        key = make_key("leaf", number)
        basis: Selection = Explicit(members) if field is None else FieldRange(field, label, label)
        name = f"Leaf {number}" if field is None else f"{field} {label:g}"
        steps.append(PutLeaf(key, Leaf(key, scan, name, members, (basis,))))
        keys.append(key)
    if steps:
        project.do(Several(f"Find {len(steps)} leaves", tuple(steps)))
    return keys


def _groups(labels: Floats) -> Iterable[tuple[float, Ints]]:
    rows = np.flatnonzero(np.isfinite(labels) & (labels >= 0))
    order = rows[np.argsort(labels[rows], kind="stable")]
    values, starts = np.unique(labels[order], return_index=True)
    return zip(values.tolist(), np.split(order, starts[1:]), strict=True) if len(rows) else ()


def key_number(key: str) -> int:
    """The number in a key: 3 of ``leaf-00003``."""
    return int(key.rpartition("-")[2])


def measure_leaves(
    project: Project, scan: str, keys: Sequence[str] | None = None, progress: Progress = QUIET
) -> list[Row]:
    """Measure leaves: plane, angles, channels, indices. Only their points are computed.

    Angles are None where the scanner's position is unknown. An index stands twice: as mean
    of the points' indices and as index of the means, named so (Hancock 2017, Junttila 2016).
    """
    leaves = [leaf for leaf in project.state.leaves_of(scan) if keys is None or leaf.key in keys]
    if not leaves:
        return []
    state = project.state.scan(scan)
    points = join_members(leaves, len(state.scan))
    points = points[state.alive[points]]
    columns = _columns(project, scan, points, progress)
    rows: list[Row] = []
    for number, leaf in enumerate(leaves):
        progress.report(number / len(leaves), "Measuring leaves")
        own_points = leaf.members.indices[state.alive[leaf.members.indices]]
        inside = np.searchsorted(points, own_points)
        own = {name: values[inside] for name, values in columns.items()}
        rows.append(_measure(project, leaf, own_points, own))
    return rows


def _columns(project: Project, scan: str, points: Ints, progress: Progress) -> dict[str, AnyArray]:
    state = project.state.scan(scan)
    columns: dict[str, AnyArray] = {}
    if state.scan.pose is not None:
        columns["incidence"] = project.field(scan, "incidence", points, progress)
    for channel in state.channels:
        columns[channel.name] = project.field(scan, channel.name, points)
    return columns


def _measure(project: Project, leaf: Leaf, points: Ints, values: dict[str, AnyArray]) -> Row:
    state = project.state.scan(leaf.scan)
    row: Row = {"leaf": leaf.key, "name": leaf.name, "points": len(points)}
    row |= _measure_plane(project, leaf.scan, points)
    if "incidence" in values:
        row["incidence_mean_deg"], row["incidence_sd_deg"] = _mean_sd(values["incidence"])
    for channel in state.channels:
        mean, sd = _mean_sd(values[channel.name])
        row |= {f"{channel.name}_mean": mean, f"{channel.name}_sd": sd}
        if channel.workflow:
            row |= _tell_marked(project, leaf.scan, channel.name, points)
        elif channel.calibration and channel not in state.scan.channels:
            row |= _tell_sigma(project, leaf.scan, channel.name, points)
    for workflow in state.workflows:
        row |= _measure_indices(state, workflow, values)
    return row


def _measure_indices(state: ScanState, workflow: str, values: dict[str, AnyArray]) -> Row:
    """Indices of a leaf over the channels of one workflow, both as mean and of the means."""
    row: Row = {}
    for index in NAMED.values():
        try:
            roles = match_channels(index, state.wavelengths_of(workflow))
        except MissingChannel:
            continue  # the scan has not the channels of this index: no column for it
        name = f"{index.name}_{workflow}" if workflow else index.name
        per_point = evaluate_index(index, {r: values[c] for r, c in roles.items()})
        means = {r: np.array([_mean(values[c])]) for r, c in roles.items()}
        row[f"{name}_mean_of_points"], row[f"{name}_sd"] = _mean_sd(per_point)
        row[f"{name}_of_means"] = _number(evaluate_index(index, means)[0])
    return row


def _tell_marked(project: Project, scan: str, channel: str, points: Ints) -> Row:
    """Points of a leaf with a corrected value, and those that are marked."""
    marks = project.field(scan, channel + MARK, points)
    values = project.field(scan, channel, points)
    return {
        f"{channel}_n": int(np.isfinite(values).sum()),
        f"{channel}_marked": int((marks != GOOD).sum()),
    }


def _tell_sigma(project: Project, scan: str, channel: str, points: Ints) -> Row:
    """σ of a mean reflectance and its parts; what points share does not average out."""
    told = explain_reflectance(project, scan, channel, points)
    parts = {f"{channel}_sigma_{part}": _number(sigma) for part, sigma in told.parts.items()}
    return {f"{channel}_sigma": _number(told.sigma), **parts, f"{channel}_n": told.n}


def _measure_plane(project: Project, scan: str, points: Ints) -> Row:
    from app.core.planes import leaf_plane

    state = project.state.scan(scan)
    names: tuple[str, ...] = ("incidence_plane_deg", "plane_rmse_m", "plane_outlier_share")
    scanner = None
    try:
        scanner = state.scan.scanner("the angle of a leaf")
    except MissingScanner:
        names = names[1:]
    try:
        plane = leaf_plane(state.scan.xyz[points], scanner, state.parameters.plane_gate)
    except BadInput as error:
        return {**dict.fromkeys(names), "plane_method": str(error)}
    values = {
        "incidence_plane_deg": _number(to_degrees(plane.incidence)),
        "plane_rmse_m": _number(plane.rmse),
        "plane_outlier_share": _number(plane.outlier_share),
    }
    return {**{name: values[name] for name in names}, "plane_method": plane.method}


def _mean(values: Floats) -> float:
    mean, _ = _mean_sd(values)
    return np.nan if mean is None else mean


def _mean_sd(values: Floats) -> tuple[float | None, float | None]:
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return None, None
    return float(finite.mean()), float(finite.std(ddof=1)) if len(finite) > 1 else None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def write_table(
    rows: Sequence[Row], path: Path, overwrite: bool = False, columns: Sequence[str] = ()
) -> None:
    """Write rows as CSV; missing values are empty cells, numbers are exact.

    `columns` stand in the header even where no row has them.
    """
    names = list(dict.fromkeys([*(name for row in rows for name in row), *columns]))
    with atomic_path(path, overwrite) as temporary, temporary.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(names)
        for row in rows:
            table.writerow([_cell(row.get(name)) for name in names])


def _cell(value: str | float | int | None) -> str:
    if value is None:
        return ""
    risky = isinstance(value, str) and value.startswith(("=", "+", "-", "@"))
    if risky and not NUMBER.fullmatch(str(value)):
        return f"'{value}"  # a spreadsheet must not run a leaf's name as a formula
    return repr(value) if isinstance(value, float) else str(value)
