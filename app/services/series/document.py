"""A series in an open session: made, confirmed, corrected and measured; each change can be undone.

The leaves of the other scans are never copied into the document: they follow from the reference,
the axis and the corrections, and are found anew when somebody looks.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from msgspec.structs import replace

from app.core.carry import USUAL, Tolerance
from app.core.errors import BadInput, WrongUse
from app.core.holder import FittedAxis
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_mm, to_radians
from app.model.operations import AddScan, PutSeries, SetDeleted, SetParameters
from app.model.points import PointSet
from app.model.project import Project
from app.model.series import HolderAxis, Series, SeriesEntry
from app.model.state import next_key
from app.services.leaves import Row
from app.services.series.axis import (
    Sighting,
    as_record,
    choose_far_scan,
    choose_scans,
    choose_sense,
    find_axis,
)
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


def change_series(
    project: Project,
    key: str,
    name: str,
    entries: Sequence[SeriesEntry],
    reference: str,
) -> None:
    """Make another series of one, as one step; what was said of its leaves stays.

    With another reference the leaves are others, and what was said of the old ones goes.
    """
    old = series_of(project, key)
    stays = old.reference == reference
    said = {one.scan: one.corrections for one in old.entries} if stays else {}
    kept = tuple(replace(one, corrections=said.get(one.scan, ())) for one in entries)
    changed = replace(old, name=name, entries=kept, reference=reference)
    project.do(PutSeries(key, changed, "Change"))


def series_of(project: Project, key: str) -> Series:
    """The series of that key; raises `WrongUse` when there is none."""
    if key not in project.state.series:
        raise WrongUse(f"There is no series {key} in this session.")
    return project.state.series[key]


def set_axis(project: Project, key: str, axis: HolderAxis | None) -> None:
    """Carry leaves about another axis, or (None) in the same pose; one step to undo."""
    series = series_of(project, key)
    project.do(PutSeries(key, replace(series, axis=axis), "Set the axis of"))


def correct_leaves(
    series: Series, scan: str, said: Mapping[str, PointSet | None], verb: str = "Correct"
) -> PutSeries:
    """The step that says which points leaves have in one scan.

    Parameters
    ----------
    series : Series
    scan : str
    said : mapping of str to PointSet or None
        By leaf; no points: it is not there; None: carry it again.
    verb : str
        Of the step's title.

    Raises
    ------
    WrongUse
        The scan is the reference, or not in the series.
    """
    if scan == series.reference:
        raise WrongUse("Leaves of the reference scan are changed there, as leaves.")
    changed = series
    for leaf, members in said.items():
        changed = changed.correct(scan, leaf, members)
    one = "a leaf" if len(said) == 1 else f"{len(said)} leaves"
    return PutSeries(series.key, changed, f"{verb} {one} in")


def read_leaves(project: Project, key: str, tolerance: Tolerance = USUAL) -> Reference:
    """The leaves of a series, ready to be carried: as long as they stay, read them once."""
    series = series_of(project, key)
    return gather_reference(project, series.reference, Path(series.reference), tolerance)


def fit_series_axis(
    project: Project,
    key: str,
    reference: Reference,
    tolerance: Tolerance = USUAL,
    progress: Progress = QUIET,
) -> FittedAxis:
    """Fit the axis to scans of a series and put it to use, as one step.

    Raises
    ------
    BadInput
        The angles are not known, or do not tell the axis.
    """
    series = series_of(project, key)
    angles = _turns(series)
    if len(angles) - angles.count(None) < 2:
        raise BadInput("The angles of the holder are not known.", "Give them to the scans.")
    fitted = find_axis(reference, _sight(project, series, angles, progress), tolerance)
    set_axis(project, key, as_record(fitted.axis, describe_fit(fitted)))
    return fitted


def describe_fit(fitted: FittedAxis) -> str:
    """How an axis was fitted, and how well the planes agree with it."""
    tilt, offset = to_degrees(fitted.tilt_rms), to_mm(fitted.offset_rms)
    return f"fit of {fitted.planes} planes, which differ by {tilt:.2g}° and {offset:.2g} mm"


def turn_axis(
    project: Project,
    key: str,
    axis: HolderAxis,
    reference: Reference,
    tolerance: Tolerance = USUAL,
) -> HolderAxis:
    """Put a typed or picked axis to use, the way round in which the leaves are found; one step."""
    series = series_of(project, key)
    angles = _turns(series)
    number = choose_far_scan(angles)
    if number is not None:
        angle = angles[number] or 0.0
        sighting = (angle, view_scan(project, series.entries[number].scan))
        axis = choose_sense(axis, reference, sighting, tolerance)
    set_axis(project, key, axis)
    return axis


def _turns(series: Series) -> list[float | None]:
    """Radians by which the holder stands from the reference, by entry; None where unknown."""
    start = series.entry(series.reference).angle_deg
    return [
        None if one.angle_deg is None or start is None else float(to_radians(one.angle_deg - start))
        for one in series.entries
    ]


def _sight(
    project: Project, series: Series, angles: Sequence[float | None], progress: Progress
) -> Iterator[Sighting]:
    chosen = choose_scans(angles)
    for place, number in enumerate(chosen):
        scan, angle = series.entries[number].scan, angles[number]
        name = project.state.scan(scan).scan.name
        progress.report(place / len(chosen), f"Following the leaves, {name}")
        if angle is not None:
            yield angle, view_scan(project, scan)


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
