"""The one who writes to the document: holds project and view, tells panels what changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
from PySide6.QtCore import QObject, QTimer, Signal

from app.core.arrays import Ints
from app.core.errors import LeafscopeError
from app.core.progress import Progress
from app.model.events import Change
from app.model.fields import Values
from app.model.operations import AnyOperation
from app.model.project import Project
from app.model.scene import Scene, resolve
from app.model.state import ScanState
from app.model.view_state import ViewState
from app.services.jobs import Job
from widgets.bridge import Bridge

EVERYTHING = Change(
    frozenset(
        {
            "scans",
            "points",
            "pose",
            "channels",
            "deleted",
            "ghosts",
            "selection",
            "parameters",
            "leaves",
            "fits",
            "samples",
            "fields",
        }
    )
)


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
        self._running: dict[tuple[str, str], Job] = {}
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
        for job in self.bridge.jobs:
            job.cancel()
        self._running.clear()
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
        while len(self.project.history.done) > steps_in_force:
            self.undo()
        while len(self.project.history.done) < steps_in_force and self.project.history.undone:
            self.redo()

    def look(self, **changes: Any) -> None:
        """Change how the document is looked at, e.g. ``look(colour="ndi")``.

        A field that is asked for and not there yet is computed in the background.
        """
        self.view = msgspec.structs.replace(self.view, **changes)
        self.view_changed.emit(self.view)
        self._later.start()
        if self.view.colour:
            for key, state in self.project.state.scans.items():
                if not state.closed and key not in self.view.hidden:
                    self.want(key, self.view.colour)

    def want(
        self,
        scan: str,
        field: str,
        points: Ints | None = None,
        then: Callable[[], None] | None = None,
    ) -> None:
        """Have a field computed for points (None: all) in the background, then call `then`."""
        if field not in self.project.catalogue(scan):
            self.said.emit(f"{self.project.state.scan(scan).scan.name} has no field {field}.")
            return
        known = self.project.known_field(scan, field)
        if known is not None and known.covers(points):
            if then is not None:
                then()
            return
        if points is None and (scan, field) in self._running and then is None:
            return
        project, evaluation = self.project, self.project.evaluation(scan)

        def work(progress: Progress) -> dict[str, Values]:
            evaluation.progress = progress
            evaluation.read(field, points)
            return evaluation.results

        def done(results: dict[str, Values]) -> None:
            if project is self.project:
                project.accept(scan, results)
                if then is not None:
                    then()

        title = self.project.catalogue(scan)[field].title
        self._running[scan, field] = self.bridge.submit(f"Computing {title}", work, done)

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
        if change.aspects - {"fields", "selection"} and self.view.colour:
            self._refresh_colour()

    def _refresh_colour(self) -> None:
        # What colours the view may have become stale; ask for it again, once.
        for cloud in resolve(self.project, self.view).clouds:
            if cloud.missing and cloud.missing in self.project.catalogue(cloud.scan):
                self.want(cloud.scan, cloud.missing)

    def _resolve(self) -> None:
        self._running = {key: job for key, job in self._running.items() if not job.over}
        self.scene = resolve(self.project, self.view)
        self.scene_changed.emit(self.scene)

    def _report(self, job: Job) -> None:
        error = job.error
        if isinstance(error, LeafscopeError):
            self.failed.emit(error)
        elif error is not None:
            wrapped = LeafscopeError(f"{job.title} failed: {error}.", "Please report it.")
            wrapped.__cause__ = error
            self.failed.emit(wrapped)
