"""From the worker's thread to the window's: the only place where the two meet."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal, Slot

from app.core.progress import Progress
from app.services.jobs import Job, JobQueue

Done = Callable[[Any], None]


class Bridge(QObject):
    """Runs work in the worker and brings its news and its result to the GUI thread.

    Signals
    -------
    job_changed(Job)
        Something about a job is different: its state, its progress.
    job_failed(Job)
        It ended with an error that somebody must be told.
    """

    job_changed = Signal(object)
    job_failed = Signal(object)
    _told = Signal(object, str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._queue = JobQueue(self._tell)
        self._waiting: dict[Job, Done] = {}
        self._told.connect(self._arrive, Qt.ConnectionType.QueuedConnection)

    def submit(self, title: str, work: Callable[[Progress], Any], done: Done) -> Job:
        """Run `work` in the worker; `done` gets its result on the GUI thread.

        `done` is not called when the work fails or is cancelled.
        """
        job = self._queue.submit(title, work)
        self._waiting[job] = done
        self.job_changed.emit(job)
        return job

    @property
    def jobs(self) -> tuple[Job, ...]:
        """Jobs that have not ended yet, oldest first."""
        return tuple(self._waiting)

    def abandon(self) -> None:
        """Cancel everything; what has ended already, but did not arrive yet, is ignored."""
        for job in self._waiting:
            job.cancel()
            self._waiting[job] = _ignore

    def close(self) -> None:
        """Cancel everything and end the worker; call before the application goes."""
        self._waiting.clear()
        self._queue.close()

    def _tell(self, job: Job) -> None:
        # Runs in the worker's thread: only a queued signal may leave from here. The state
        # travels with it, since the job goes on changing meanwhile.
        self._told.emit(job, job.state)

    @Slot(object, str)
    def _arrive(self, job: Job, state: str) -> None:
        if job not in self._waiting:
            return
        done = self._waiting.pop(job) if state in ("done", "failed", "cancelled") else None
        try:
            if done is not None and state == "done":
                done(job.result)
        finally:
            self.job_changed.emit(job)
        if state == "failed":
            self.job_failed.emit(job)


def _ignore(_: object) -> None:
    """The result of a job that was abandoned."""
