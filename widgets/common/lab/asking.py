"""A question to the worker that the user can take back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.core.errors import Cancelled, LeafscopeError
from app.core.progress import Progress
from app.services.jobs import Job
from widgets.controller import Controller


class Asking(QObject):
    """One question at a time; a later one takes the earlier back.

    Signals
    -------
    changed()
        A question is under way, or is not any more.
    refused(str)
        Why there is no answer, as a sentence.
    progressed(float, str)
        Share of the question that is answered, and what is being done.
    """

    changed = Signal()
    refused = Signal(str)
    progressed = Signal(float, str)

    def __init__(self, controller: Controller, parent: QObject) -> None:
        super().__init__(parent)
        self._controller = controller
        self._job: Job | None = None
        controller.bridge.job_changed.connect(self._on_job)

    @property
    def busy(self) -> bool:
        """Whether a question is under way."""
        return self._job is not None

    def ask(self, title: str, work: Callable[[Progress], Any], done: Callable[[Any], None]) -> None:
        """Let the worker answer; `done` gets the answer, `refused` an error of the user's."""
        self.cancel()

        def answer(progress: Progress) -> Any:
            try:
                return work(progress)
            except Cancelled:
                raise
            except LeafscopeError as error:
                return error

        def take(found: Any) -> None:
            if job is not self._job:
                return
            self._end()
            if isinstance(found, LeafscopeError):
                self.refused.emit(str(found))
            else:
                done(found)

        job = self._controller.run(title, answer, take)
        self._job = job
        self.changed.emit()

    def cancel(self) -> None:
        """Take the question back."""
        if self._job is not None:
            self._job.cancel()
            self._end()

    def _on_job(self, job: Job) -> None:
        if job is not self._job:
            return
        if job.state in ("failed", "cancelled"):
            self._end()
        else:
            self.progressed.emit(job.fraction, job.text)

    def _end(self) -> None:
        self._job = None
        self.changed.emit()
