"""A series in an open session: made, confirmed, corrected and measured; each change can be undone.

The leaves of the other scans are never copied into the document: they follow from the reference,
the axis and the corrections, and are found anew when somebody looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from msgspec.structs import replace

from app.core.carry import USUAL, Tolerance
from app.core.errors import BadInput, WrongUse
from app.core.holder import FittedAxis
from app.core.progress import QUIET, Progress
from app.core.units import to_radians
from app.model.operations import AddScan, PutSeries, SetDeleted, SetParameters
from app.model.points import PointSet
from app.model.project import Project
from app.model.series import HolderAxis, Series, SeriesEntry
from app.model.state import next_key
from app.services.leaves import Row
from app.services.series.axis import as_record, find_axis
from app.services.series.carrying import Found, carry_leaves, keep_leaves, motion_of
from app.services.series.entries import Entry
from app.services.series.measuring import measure_found
from app.services.series.reference import Reference, gather_reference, view_scan


def make_series(
    project: Project,
    name: str,
    entries: Sequence[SeriesEntry],
    reference: str,
    axis: HolderAxis | None = None,
) -> str:
    """Make a series of scans of a session, as one step; give its key."""
    key = next_key(project.state.series, "series")
    project.do(PutSeries(key, Series(key, name, tuple(entries), reference, axis)))
    return key


def series_of(project: Project, key: str) -> Series:
    """The series of that key; raises `WrongUse` when there is none."""
    if key not in project.state.series:
        raise WrongUse(f"There is no series {key} in this session.")
    return project.state.series[key]


def set_axis(project: Project, key: str, axis: HolderAxis | None) -> None:
    """Carry leaves about another axis, or (None) in the same pose; one step to undo."""
    series = series_of(project, key)
    project.do(PutSeries(key, replace(series, axis=axis), "Set the axis of"))


def correct_leaf(
    project: Project, key: str, scan: str, leaf: str, members: PointSet | None
) -> None:
    """Say which points a leaf has in one scan; none: it is not there; None: carry it again."""
    series = series_of(project, key)
    if scan == series.reference:
        raise WrongUse("Leaves of the reference scan are changed there, as leaves.")
    project.do(PutSeries(key, series.correct(scan, leaf, members), "Correct a leaf in"))


def read_leaves(project: Project, key: str, tolerance: Tolerance = USUAL) -> Reference:
    """The leaves of a series, ready to be carried: as long as they stay, read them once."""
    series = series_of(project, key)
    return gather_reference(project, series.reference, Path(series.reference), tolerance)


def fit_series_axis(
    project: Project, key: str, reference: Reference, tolerance: Tolerance = USUAL
) -> FittedAxis:
    """Fit the axis to all scans of a series and put it to use, as one step.

    Raises
    ------
    BadInput
        The angles are not known, or do not tell the axis.
    """
    series = series_of(project, key)
    start = series.entry(series.reference).angle_deg
    turned = [
        (float(to_radians(entry.angle_deg - start)), entry.scan)
        for entry in series.entries
        if entry.angle_deg is not None and start is not None
    ]
    if len(turned) < 2:
        raise BadInput("The angles of the holder are not known.", "Give them to the scans.")
    ordered = sorted(turned, key=lambda pair: abs(pair[0]))
    scans = ((angle, view_scan(project, scan)) for angle, scan in ordered)
    fitted = find_axis(reference, scans, tolerance)
    set_axis(project, key, as_record(fitted.axis, f"fit of {fitted.planes} planes"))
    return fitted


def find_in_scan(
    project: Project, key: str, scan: str, reference: Reference, tolerance: Tolerance = USUAL
) -> list[Found]:
    """The leaves of a series in one of its scans, to be shown and confirmed."""
    series = series_of(project, key)
    view = view_scan(project, scan)
    if scan == series.reference:
        return keep_leaves(view, reference)
    entry = series.entry(scan)
    start = series.entry(series.reference).angle_deg
    motion = motion_of(series.axis, entry.angle_deg, start)
    said = {one.leaf: one.members for one in entry.corrections}
    return carry_leaves(view, reference, motion, tolerance, said)


def measure_series(
    project: Project,
    key: str,
    tolerance: Tolerance = USUAL,
    full_hits: bool = False,
    progress: Progress = QUIET,
) -> list[Row]:
    """The table of a series in a session: the rows that ``leafscope series`` writes."""
    series, reference = series_of(project, key), read_leaves(project, key, tolerance)
    rows: list[Row] = []
    for number, entry in enumerate(series.entries):
        part = progress.part(number / len(series.entries), (number + 1) / len(series.entries))
        part.report(0.0, f"Measuring {project.state.scan(entry.scan).scan.name}")
        found = find_in_scan(project, key, entry.scan, reference, tolerance)
        aside, own = copy_aside(project, entry.scan)
        rows += measure_found(aside, own, _describe(project, entry), found, full_hits, part)
    return rows


def _describe(project: Project, entry: SeriesEntry) -> Entry:
    source = project.state.scan(entry.scan).scan.source
    file = Path(project.state.scan(entry.scan).scan.name if source is None else source.path)
    return Entry(file, entry.angle_deg, entry.hours, None, entry.treatment, entry.label)


def copy_aside(project: Project, scan: str) -> tuple[Project, str]:
    """A project with one scan only, as it is in another: to measure leaves that are no document's.

    It shares the points; nothing done to it comes back.
    """
    state = project.state.scan(scan)
    aside = Project()
    key = aside.shelve(state.scan)
    aside.do(AddScan(key, state.scan.name, state.scan.source))
    if state.deleted.any():
        aside.do(SetDeleted(key, PointSet.from_mask(state.deleted)))
    aside.do(SetParameters(key, state.parameters))
    return aside, key
