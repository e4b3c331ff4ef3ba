"""Scans of a series, read one ahead of the one that is worked on."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import TimeoutError as NotYet

from app.core.errors import BadInput
from app.core.progress import LiveProgress, Progress
from app.model.project import Project
from app.services.opening import open_file, set_parameters
from app.services.series.entries import Entry
from app.services.series.order import SeriesOrder

POLL = 0.1
"""Seconds after which a cancel is looked for while a scan is read."""


def open_entry(order: SeriesOrder, entry: Entry, progress: Progress) -> tuple[Project, str]:
    """Read a scan of a series into a project of its own."""
    project, keys = open_file(order.open(entry.file), progress)
    if len(keys) != 1:
        raise BadInput(
            f"{entry.file.name} holds {len(keys)} scans; a series takes files of one.",
            "Write them to files of their own.",
        )
    set_parameters(project, keys[0], **order.parameters)
    return project, keys[0]


class ReadAhead:
    """Reads the next scan in a thread while one is measured."""

    def __init__(self, order: SeriesOrder, entries: Sequence[Entry]) -> None:
        self._order, self._entries = order, entries
        self._stop = threading.Event()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="series")
        self._waiting: dict[int, Future[tuple[Project, str]]] = {}

    def __enter__(self) -> ReadAhead:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def take(self, number: int, progress: Progress) -> tuple[Project, str]:
        """The scan of that number, as soon as it is read; raises what its reading raises."""
        self._begin(number)
        self._begin(number + 1)
        waiting = self._waiting.pop(number)
        while True:
            progress.report(0.0, f"Reading {self._entries[number].file.name}")
            try:
                return waiting.result(POLL)
            except NotYet:
                continue

    def _begin(self, number: int) -> None:
        if number < len(self._entries) and number not in self._waiting:
            silent = LiveProgress(_say_nothing, self._stop.is_set)
            self._waiting[number] = self._pool.submit(
                open_entry, self._order, self._entries[number], silent
            )


def _say_nothing(_fraction: float, _text: str) -> None:
    """Progress of a scan that is read ahead."""
