"""Run times: rivals take turns, so that a busy moment of the machine hits them all."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median

from app.core.chunks import count_processors
from app.core.progress import QUIET, Progress


@dataclass(frozen=True, slots=True)
class Timing:
    """Seconds of the repeats of one rival."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """The middle one."""
        return median(self.seconds)


def time_in_turns(
    rivals: Mapping[str, Callable[[], object]], repeats: int, progress: Progress = QUIET
) -> dict[str, Timing]:
    """Time each rival `repeats` times, one after the other and then again from the first.

    They should have been run once before, so that nothing is compiled while the clock runs.
    """
    taken: dict[str, list[float]] = {name: [] for name in rivals}
    for turn in range(repeats):
        for place, (name, run) in enumerate(rivals.items()):
            progress.report((turn + place / len(rivals)) / repeats, f"Timing {name}")
            start = time.perf_counter()
            run()
            taken[name].append(time.perf_counter() - start)
    return {name: Timing(tuple(seconds)) for name, seconds in taken.items()}


def can_choose_threads() -> bool:
    """Whether `use_threads` works on this system."""
    return hasattr(os, "sched_setaffinity")


@contextmanager
def use_threads(count: int) -> Iterator[None]:
    """Let only `count` processors, and so as many threads, work on what runs inside."""
    if count >= count_processors():
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(allowed)[:count])
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)
