"""A series from files to a table: one scan after the other is read, measured and forgotten."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.core.errors import BadInput, Cancelled, LeafscopeError
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees, to_mm, to_radians
from app.formats.atomic import refuse_target
from app.model.project import Project
from app.model.series import HolderAxis
from app.services.leaves import Row, write_table
from app.services.series.axis import (
    Sighting,
    as_record,
    choose_far_scan,
    choose_scans,
    choose_sense,
    find_axis,
    parse_axis,
)
from app.services.series.carrying import carry_leaves, keep_leaves, motion_of
from app.services.series.entries import Entry, Understood
from app.services.series.measuring import measure_found, unread_rows
from app.services.series.order import (
    FIT,
    SeriesOrder,
    choose_reference,
    list_scans,
    series_entries,
    understand,
)
from app.services.series.read_ahead import ReadAhead
from app.services.series.reference import FIND, Reference, read_reference, same_file, view_scan


@dataclass(frozen=True, slots=True)
class UsedAxis:
    """The axis that leaves were carried about, and how well planes agree with it if fitted."""

    axis: HolderAxis
    tilt_rms_deg: float | None = None
    offset_rms_mm: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "point": list(self.axis.point),
            "direction": list(self.axis.direction),
            "origin": self.axis.origin,
            "tilt_rms_deg": self.tilt_rms_deg,
            "offset_rms_mm": self.offset_rms_mm,
        }


@dataclass(frozen=True, slots=True)
class SeriesTable:
    """The table of a series, and what is worth telling.

    Attributes
    ----------
    rows : list of Row
        One for each leaf and scan.
    understood : Understood
    reference : Path
    axis : UsedAxis or None
    warnings : tuple of str
    unread : tuple of str
        Files that could not be read.
    """

    rows: list[Row]
    understood: Understood
    reference: Path
    axis: UsedAxis | None
    warnings: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    @property
    def verdicts(self) -> dict[str, int]:
        """How many rows have each verdict."""
        return dict(Counter(str(row["verdict"]) for row in self.rows))

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope series``."""
        return {
            "understood": self.understood.how,
            "scans": len(self.understood.entries),
            "reference": str(self.reference),
            "axis": None if self.axis is None else self.axis.as_dict(),
            "verdicts": self.verdicts,
            "warnings": list(self.warnings),
            "unread": list(self.unread),
            "rows": self.rows,
        }


@dataclass(slots=True)
class _Run:
    """A series on its way: what it is, and what has been done."""

    order: SeriesOrder
    understood: Understood
    reference: Reference
    from_deg: float | None
    axis: UsedAxis | None = None
    rows: list[Row] = field(default_factory=list)
    unread: dict[str, str] = field(default_factory=dict)


def tabulate_series(
    order: SeriesOrder, out: Path, overwrite: bool = False, progress: Progress = QUIET
) -> SeriesTable:
    """Carry leaves through the scans of a series, measure them, and write the table as CSV.

    The table is written anew after every scan: what is done stays when a later one fails or the
    user cancels. A scan that cannot be read gets rows that say so. No more than two scans are in
    memory: one that is measured, and the next, which is read meanwhile.

    Raises
    ------
    BadInput, WrongUse
        The scans, what they are, the leaves, or the axis cannot be understood.
    Cancelled
    """
    refuse_target(out, overwrite, sources=order.sources())
    run = _prepare(order, progress.part(0.0, 0.1))
    refuse_target(out, overwrite, sources=[each.file for each in run.understood.entries])
    run.axis = _choose_axis(run, progress.part(0.1, 0.5))
    _measure(run, out, progress.part(0.5, 1.0))
    warnings = [*run.reference.warnings, *(f"{file}: {why}" for file, why in run.unread.items())]
    return SeriesTable(
        run.rows, run.understood, run.reference.file, run.axis, tuple(warnings), tuple(run.unread)
    )


def _prepare(order: SeriesOrder, progress: Progress) -> _Run:
    """Understand the scans and read the leaves."""
    files = list_scans(order.files)
    if order.leaves == FIND:
        place = choose_reference(order, understand(files, order))
    else:
        place = Path(order.leaves)
    reference = read_reference(
        order.leaves, order.open(place), order.label_field, order.tolerance, progress
    )
    if not files:
        understood = series_entries(reference)
    else:
        inside = any(same_file(file, reference.file) for file in files)
        understood = understand(files if inside else [*files, reference.file], order)
    own = next((e for e in understood.entries if same_file(e.file, reference.file)), None)
    if files:
        kept = tuple(e for e in understood.entries if e.file in files)
        understood = Understood(kept, understood.how)
    return _Run(order, understood, reference, own.angle_deg if own is not None else None)


def _choose_axis(run: _Run, progress: Progress) -> UsedAxis | None:
    """The axis that was asked for; fitted where angles change and nothing is said."""
    order, known = run.order, run.reference.series
    if order.same_pose or (order.axis is None and not run.understood.turns):
        return None
    if order.axis is None and known is not None and (known.axis is not None or not order.files):
        # A series that the window measures in the same pose is not turned here.
        return None if known.axis is None else UsedAxis(known.axis)
    angles = _angles(run)
    if order.axis not in (None, FIT):
        axis, number = parse_axis(str(order.axis)), choose_far_scan(angles)
        chosen = [] if number is None else [number]
        for scan in _look(run, chosen, angles, progress):
            axis = choose_sense(axis, run.reference, scan, order.tolerance)
        return UsedAxis(axis)
    scans = _look(run, choose_scans(angles), angles, progress)
    fitted = find_axis(run.reference, scans, order.tolerance)
    run.reference = run.reference.with_normals(fitted.normals)
    record = as_record(fitted.axis, f"fit of {fitted.planes} planes")
    return UsedAxis(record, float(to_degrees(fitted.tilt_rms)), float(to_mm(fitted.offset_rms)))


def _angles(run: _Run) -> list[float | None]:
    """Angle of the holder in each scan, radians from the reference; None where unknown."""
    if run.from_deg is None:
        raise BadInput(
            f"The holder's angle in {run.reference.file.name}, where the leaves come from, is not "
            "known.",
            "Let the names or the table say it, or take a scan of the series.",
        )
    return [
        None if entry.angle_deg is None else float(to_radians(entry.angle_deg - run.from_deg))
        for entry in run.understood.entries
    ]


def _look(
    run: _Run, chosen: Sequence[int], angles: Sequence[float | None], progress: Progress
) -> Iterator[Sighting]:
    """Some of the scans, one after the other; those that cannot be read are told later."""
    entries = [run.understood.entries[number] for number in chosen]
    with ReadAhead(run.order, entries) as ahead:
        for place, number in enumerate(chosen):
            part = progress.part(place / len(chosen), 1.0)
            part.report(0.0, f"Following the leaves, {entries[place].file.name}")
            angle = angles[number]
            try:
                view = view_scan(*ahead.take(place, part))
            except Cancelled:
                raise
            except LeafscopeError:
                continue
            if angle is not None:
                yield angle, view


def _measure(run: _Run, out: Path, progress: Progress) -> None:
    entries = run.understood.entries
    with ReadAhead(run.order, entries) as ahead:
        for number, entry in enumerate(entries):
            share = number / len(entries)
            progress.report(share, f"Measuring {entry.file.name}")
            part = progress.part(share, (number + 1) / len(entries))
            try:
                project, key = ahead.take(number, part)
                run.rows += _measure_entry(run, entry, project, key, part)
                del project
            except Cancelled:
                raise
            except LeafscopeError as error:
                run.unread[entry.file.name] = str(error)
                run.rows += unread_rows(entry, run.reference, str(error))
            write_table(run.rows, out, overwrite=True)


def _measure_entry(
    run: _Run, entry: Entry, project: Project, key: str, progress: Progress
) -> list[Row]:
    view, reference = view_scan(project, key), run.reference
    if same_file(entry.file, reference.file) and len(view.xyz) == reference.points:
        found = keep_leaves(view, reference)
    else:
        axis = None if run.axis is None else run.axis.axis
        motion = motion_of(axis, entry.angle_deg, run.from_deg)
        said = reference.corrections(entry.file)
        found = carry_leaves(view, reference, motion, run.order.tolerance, said)
    return measure_found(project, key, entry, found, run.order.full_hits, progress)
