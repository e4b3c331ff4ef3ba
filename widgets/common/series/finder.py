"""Leaves of a series found in its scans, in the worker; each scan once as long as nothing changes.

What is found belongs to nobody's document: it follows from the reference, the axis and what the
user said of single leaves, and is found anew when one of these changes.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.core.errors import Cancelled, LeafscopeError
from app.core.progress import Progress
from app.model.fields import Same
from app.model.project import Project
from app.model.series import Series
from app.services.jobs import Job
from app.services.series.carrying import Found
from app.services.series.document import find_in_scan, read_leaves
from app.services.series.reference import Reference
from widgets.common.aside import copy_aside
from widgets.controller import Controller


@dataclass(frozen=True, slots=True)
class Look:
    """What was found in a scan, or why nothing could be looked for; and for which state of it."""

    mark: Hashable
    found: tuple[Found, ...] = ()
    problem: str = ""


@dataclass(frozen=True, slots=True)
class _Result:
    mark: Hashable
    reference: Reference | None
    looks: dict[str, Look]


class Finder(QObject):
    """Carries leaves on request and remembers what it found.

    Signals
    -------
    found()
        More is known than before.
    """

    found = Signal()

    def __init__(self, controller: Controller, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._controller = controller
        self._looks: dict[tuple[str, str], Look] = {}
        self._reference: tuple[Hashable, Reference] | None = None
        self._asked: dict[tuple[str, str], Hashable] = {}
        self._job: Job | None = None

    def forget(self) -> None:
        """Let go of a document that is gone."""
        self._looks.clear()
        self._asked.clear()
        self._reference = None

    def look(self, series: Series, scan: str) -> Look | None:
        """What is known of the leaves in a scan; None: nothing, or it is out of date."""
        known = self._looks.get((series.key, scan))
        mark = mark_scan(self._controller.project, series, scan)
        return known if known is not None and known.mark == mark else None

    def reference(self, series: Series) -> Reference | None:
        """The leaves of the reference, as far as they have been read."""
        mark = mark_reference(self._controller.project, series)
        known = self._reference
        return known[1] if known is not None and known[0] == mark else None

    def want(self, series: Series, scans: Sequence[str]) -> None:
        """Look for the leaves in scans where it is not known; each state is asked for once."""
        project = self._controller.project
        marks = {scan: mark_scan(project, series, scan) for scan in scans}
        missing = [
            scan
            for scan, mark in marks.items()
            if self.look(series, scan) is None and self._asked.get((series.key, scan)) != mark
        ]
        if not missing:
            return
        for scan in missing:
            self._asked[series.key, scan] = marks[scan]
        aside = copy_aside(project, series.reference)
        of_reference = mark_reference(project, series)
        known = self.reference(series)

        def work(progress: Progress) -> _Result:
            return _find(aside, series, missing, marks, of_reference, known, progress)

        def done(result: _Result) -> None:
            if project is not self._controller.project:
                return
            if result.reference is not None:
                self._reference = (result.mark, result.reference)
            for scan, look in result.looks.items():
                self._looks[series.key, scan] = look
            self.found.emit()

        name = project.state.scan(missing[0]).scan.name
        title = self.tr("Carrying leaves to {scan}").format(scan=name)
        if len(missing) > 1:
            title = self.tr("Carrying leaves to {n} scans").format(n=len(missing))
        self._job = self._controller.run(title, work, done)

    def want_again(self, series: Series, scans: Sequence[str]) -> None:
        """The same, also for what failed or was cancelled before."""
        for scan in scans:
            self._asked.pop((series.key, scan), None)
        self.want(series, scans)

    @property
    def busy(self) -> bool:
        """Whether leaves are being carried."""
        return self._job is not None and self._job in self._controller.bridge.jobs


def mark_reference(project: Project, series: Series) -> Hashable:
    """Stands for the state of the reference scan and its leaves."""
    state = project.state.scan(series.reference)
    leaves = project.state.leaves_of(series.reference)
    told = tuple((leaf.key, leaf.name, Same(leaf.members)) for leaf in leaves)
    return Same(project), Same(state.scan), Same(state.deleted), told


def mark_scan(project: Project, series: Series, scan: str) -> Hashable:
    """Stands for everything that the leaves found in a scan depend on."""
    state, entry = project.state.scan(scan), series.entry(scan)
    start = series.entry(series.reference).angle_deg
    said = tuple((one.leaf, Same(one.members)) for one in entry.corrections)
    turned = (series.axis, start, entry.angle_deg, said)
    return mark_reference(project, series), Same(state.scan), Same(state.deleted), turned


def _find(
    aside: Project,
    series: Series,
    scans: Sequence[str],
    marks: dict[str, Hashable],
    of_reference: Hashable,
    known: Reference | None,
    progress: Progress,
) -> _Result:
    """Look into one scan after the other; runs in the worker."""
    looks: dict[str, Look] = {}
    try:
        reference = known if known is not None else read_leaves(aside, series.key)
    except LeafscopeError as error:
        looks = {scan: Look(marks[scan], problem=str(error)) for scan in scans}
        return _Result(of_reference, None, looks)
    for number, scan in enumerate(scans):
        progress.report(number / len(scans), aside.state.scan(scan).scan.name)
        try:
            found = tuple(find_in_scan(aside, series.key, scan, reference))
            looks[scan] = Look(marks[scan], found)
        except Cancelled:
            raise
        except LeafscopeError as error:
            looks[scan] = Look(marks[scan], problem=str(error))
    return _Result(of_reference, reference, looks)
