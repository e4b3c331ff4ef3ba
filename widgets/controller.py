"""The one who writes to the document: holds project and view, tells panels what changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar
from weakref import WeakSet

import msgspec
from PySide6.QtCore import QObject, QTimer, Signal

from app.core.arrays import Ints
from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.model.events import EVERYTHING, Change
from app.model.fields import Values, fingerprint
from app.model.operations import AnyOperation
from app.model.project import Project
from app.model.scene import Scene, resolve
from app.model.state import ScanState
from app.model.view_state import ViewState
from app.services.jobs import Job
from widgets.bridge import Bridge
from widgets.common.aside import copy_aside
from widgets.fields_at_hand import NOT_MEASURED

R = TypeVar("R")
Mark = tuple[Any, ...]
Then = Callable[[], None]

# Changes of the view after which the colouring field is asked for anew.
ASKING = {"colour", "hidden", "current"}


@dataclass(frozen=True, slots=True)
class _Running:
    """A field that is being computed for all points, and who waits for it."""

    mark: Mark
    job: Job
    thens: list[Then]


class Controller(QObject):
    """Panels read `project` and `view` and call methods here; nothing else changes them.

    Signals
    -------
    document_changed(Change)
    view_changed(ViewState)
    scene_changed(Scene)
        At most once per turn of the event loop.
    said(str)
        A sentence for the status bar.
    failed(LeafscopeError)
        Something went wrong; the sentence is for the user.
    """

    document_changed = Signal(object)
    view_changed = Signal(object)
    scene_changed = Signal(object)
    said = Signal(str)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.bridge = Bridge(self)
        self.bridge.job_failed.connect(self._report)
        self.project = Project()
        self.view = ViewState()
        self.scene = Scene()
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._resolve)
        self._running: dict[tuple[str, str], _Running] = {}
        self._coloured: dict[tuple[str, str], Mark] = {}
        self._quiet: WeakSet[Job] = WeakSet()
        self.project.changed.connect(self._on_change)

    @property
    def current(self) -> str | None:
        """Key of the scan that panels work on, if it is still there."""
        key = self.view.current
        state = self.project.state.scans.get(key) if key is not None else None
        return key if state is not None and not state.closed else None

    @property
    def scan(self) -> ScanState | None:
        """The scan that panels work on."""
        return None if self.current is None else self.project.state.scans[self.current]

    def adopt(self, project: Project, view: ViewState) -> None:
        """Take another document over: a session, or an empty one."""
        self.project.changed.disconnect(self._on_change)
        self.bridge.abandon()
        self._running.clear()
        self._coloured.clear()
        self.project, self.view = project, view
        self.project.changed.connect(self._on_change)
        self.document_changed.emit(EVERYTHING)
        self.look()

    def do(self, operation: AnyOperation) -> bool:
        """Apply an operation; say what went wrong if it does not fit. True when done."""
        return self.attempt(lambda: self.project.do(operation))

    def undo(self) -> None:
        """Take back the last step."""
        self.attempt(self.project.undo)

    def redo(self) -> None:
        """Do again what was undone last."""
        self.attempt(self.project.redo)

    def jump(self, steps_in_force: int) -> None:
        """Undo or redo until so many steps are in force."""
        history = self.project.history
        while len(history.done) > steps_in_force and self.attempt(self.project.undo):
            pass
        while len(history.done) < steps_in_force and history.undone:
            if not self.attempt(self.project.redo):
                break

    def look(self, **changes: Any) -> None:
        """Change how the document is looked at, e.g. ``look(colour="ndi")``.

        A field that is asked for and not there yet is computed in the background.
        """
        self.view = msgspec.structs.replace(self.view, **changes)
        self.view_changed.emit(self.view)
        self._later.start()
        if not changes or changes.keys() & ASKING:
            self._want_colour(anew=True)

    def want(
        self,
        scan: str,
        field: str,
        points: Ints | None = None,
        then: Then | None = None,
        quiet: bool = False,
    ) -> None:
        """Have a field computed for points (None: all) in the background, then call `then`.

        `then` finds valid values: what went stale meanwhile is computed again before.
        With `quiet` nobody is told when the scan lacks what the field needs.
        """
        if scan not in self.project.state.scans:
            return
        if field not in self.project.catalogue(scan):
            self.said.emit(f"{self.project.state.scan(scan).scan.name} has no field {field}.")
            return
        known = self.project.known_field(scan, field)
        if known is not None and known.covers(points):
            if then is not None:
                then()
            return
        thens = [] if then is None else [then]
        if not self._join(scan, field, thens):
            if points is None:
                thens += self._supersede(scan, field)
            self._compute(scan, field, points, thens, quiet)

    def _compute(
        self, scan: str, field: str, points: Ints | None, thens: list[Then], quiet: bool
    ) -> None:
        project, evaluation = self.project, self.project.evaluation(scan)

        def work(progress: Progress) -> dict[str, Values]:
            evaluation.progress = progress
            evaluation.read(field, points)
            return evaluation.results

        def done(results: dict[str, Values]) -> None:
            if project is self.project:
                project.accept(scan, results)
                for then in thens:
                    self.want(scan, field, points, then)

        title = project.catalogue(scan)[field].title
        job = self.bridge.submit(f"Computing {title}", work, done)
        if points is None:
            self._running[scan, field] = _Running(self._mark(scan, field), job, thens)
        if quiet:
            self._quiet.add(job)

    def carry_out(
        self,
        scan: str,
        title: str,
        service: Callable[[Project, Progress], R],
        done: Callable[[R], object] = lambda _: None,
    ) -> None:
        """Let a service work on a copy of the document in the background, then do its steps.

        When the document has changed meanwhile, the service works again on a new copy.
        """
        project, state = self.project, self.project.state
        aside = copy_aside(project, scan)

        def adopt(result: R) -> None:
            if project is not self.project:
                return
            if project.state is not state:
                self.carry_out(scan, title, service, done)
                return
            steps = [entry.operation for entry in aside.history.log if entry.operation is not None]
            if all([self.do(step) for step in steps]):
                done(result)

        self.bridge.submit(title, lambda progress: service(aside, progress), adopt)

    def run(self, title: str, work: Callable[[Progress], Any], done: Callable[[Any], None]) -> Job:
        """Run work that touches only arrays and frozen things; `done` may use the document."""
        return self.bridge.submit(title, work, done)

    def attempt(self, deed: Callable[[], Any]) -> bool:
        """Do something with the document; an error becomes a sentence. True when it went well."""
        try:
            deed()
        except LeafscopeError as error:
            self.failed.emit(error)
            return False
        return True

    def close(self) -> None:
        """Stop the worker; the window calls it last."""
        self.project.changed.disconnect(self._on_change)
        self._later.stop()
        self.bridge.close()

    def _on_change(self, change: Change) -> None:
        self.document_changed.emit(change)
        self._later.start()
        if change.aspects - {"fields", "selection"}:
            self._want_colour()

    def _want_colour(self, anew: bool = False) -> None:
        # What failed or was cancelled is not asked for again until something that it depends
        # on is different, or the user asks for the colour anew.
        field = self.view.colour
        for scan, state in self.project.state.scans.items():
            there = bool(field) and field in self.project.catalogue(scan)
            if not field or state.closed or scan in self.view.hidden or not (there or anew):
                continue
            mark = self._mark(scan, field) if there else ()
            if anew or self._coloured.get((scan, field)) != mark:
                self._coloured[scan, field] = mark
                if not (there and self.project.catalogue(scan)[field].given):
                    self.want(scan, field, quiet=not anew)
                elif self.project.known_field(scan, field) is None:
                    self.said.emit(NOT_MEASURED)  # whoever measures it hands it over

    def _mark(self, scan: str, field: str) -> Mark:
        project = self.project
        return fingerprint(project.catalogue(scan), field, project.subject(scan))

    def _join(self, scan: str, field: str, thens: list[Then]) -> bool:
        # The whole field is on its way already: wait for it.
        running = self._running.get((scan, field))
        if running is None or running.job not in self.bridge.jobs:
            return False
        if running.job.stopping or running.mark != self._mark(scan, field):
            return False
        running.thens.extend(thens)
        return True

    def _supersede(self, scan: str, field: str) -> list[Then]:
        # Nobody needs what is computed from older parameters, but who waits goes on waiting.
        running = self._running.pop((scan, field), None)
        if running is None or running.job not in self.bridge.jobs:
            return []
        running.job.cancel()
        return running.thens

    def _resolve(self) -> None:
        self.scene = resolve(self.project, self.view)
        self.scene_changed.emit(self.scene)

    def _report(self, job: Job) -> None:
        error = job.error
        if isinstance(error, LeafscopeError):
            if job not in self._quiet:
                self.failed.emit(error)
        elif error is not None:
            wrapped = LeafscopeError(f"{job.title} failed: {error}.", "Please report it.")
            wrapped.__cause__ = error
            self.failed.emit(wrapped)
