"""Long work off the caller's thread: one worker, in order, with progress and cancel. No Qt.

One worker, because two threads must not enter parallel kernels at once.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import Any, Literal

from app.core.errors import Cancelled
from app.core.progress import LiveProgress, Progress

JobState = Literal["waiting", "running", "done", "failed", "cancelled"]
Work = Callable[[Progress], Any]


class Job:
    """One piece of work and what became of it.

    Parameters
    ----------
    title : str
        What the user reads.
    work : callable
        Gets a `Progress`; must not touch the document, Qt or VTK.
    """

    def __init__(self, title: str, work: Work) -> None:
        self.title = title
        self.state: JobState = "waiting"
        self.fraction = 0.0
        self.text = ""
        self.result: Any = None
        self.error: BaseException | None = None
        self.started = 0.0
        self._work = work
        self._cancelled = threading.Event()

    @property
    def over(self) -> bool:
        """Whether the job has ended, one way or another."""
        return self.state in ("done", "failed", "cancelled")

    @property
    def seconds_left(self) -> float | None:
        """Estimate from the progress so far; None while there is too little of it."""
        if self.state != "running" or self.fraction < 0.02:
            return None
        return (time.monotonic() - self.started) * (1.0 - self.fraction) / self.fraction

    @property
    def stopping(self) -> bool:
        """Whether it was asked to stop."""
        return self._cancelled.is_set()

    def cancel(self) -> None:
        """Ask the work to stop; it does at its next report."""
        self._cancelled.set()

    def run(self, tell: Callable[[Job], None]) -> None:
        """Do the work in the calling thread; every end is told, errors included."""
        self.started = time.monotonic()
        self.state = "running"
        tell(self)

        def listen(fraction: float, text: str) -> None:
            self.fraction, self.text = fraction, text or self.text
            tell(self)

        progress = LiveProgress(listen, self._cancelled.is_set)
        try:
            progress.report(0.0)
            self.result = self._work(progress)
            self.state, self.fraction = "done", 1.0
        except Cancelled:
            self.state = "cancelled"
        except BaseException as error:  # noqa: BLE001 - handed to the asker, never lost
            self.state, self.error = "failed", error
        tell(self)


class JobQueue:
    """Runs jobs one after the other in a thread of its own.

    Parameters
    ----------
    tell : callable
        Called from the worker's thread with the job whenever something about it changes.
    """

    def __init__(self, tell: Callable[[Job], None]) -> None:
        self._tell = tell
        self._queue: queue.Queue[Job | None] = queue.Queue()
        self._current: Job | None = None
        self._closing = False
        self._thread = threading.Thread(target=self._serve, name="leafscope-worker", daemon=True)
        self._thread.start()

    def submit(self, title: str, work: Work) -> Job:
        """Queue a piece of work and give its job."""
        job = Job(title, work)
        self._queue.put(job)
        return job

    def close(self, wait: float = 2.0) -> None:
        """Cancel what runs, drop what waits, end the thread."""
        self._closing = True
        current = self._current  # the worker may let go of it at any moment
        if current is not None:
            current.cancel()
        self._queue.put(None)
        self._thread.join(wait)

    def _serve(self) -> None:
        while (job := self._queue.get()) is not None:
            self._current = job
            if self._closing:
                continue
            job.run(self._tell)
            self._current = None
