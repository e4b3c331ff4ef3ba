"""Progress on a terminal, and the cancel by Ctrl-C or a polite kill."""

from __future__ import annotations

import signal
import sys
import time
from typing import TYPE_CHECKING

from app.core.progress import LiveProgress, Progress

if TYPE_CHECKING:
    from types import FrameType

PATIENCE = 1.0
INTERVAL = 0.1


class _Watcher:
    def __init__(self) -> None:
        self.stop = False
        self._started = self._shown = time.monotonic()
        self._terminal = sys.stderr.isatty()

    def ask_to_stop(self, number: int, frame: FrameType | None) -> None:
        if self.stop:  # asked twice: do not wait for the next report
            raise KeyboardInterrupt
        self.stop = True

    def tell(self, fraction: float, text: str) -> None:
        now = time.monotonic()
        if self._terminal and now - self._started > PATIENCE and now - self._shown > INTERVAL:
            self._shown = now
            print(f"\r\x1b[2K{fraction:4.0%} {text}", end="", file=sys.stderr, flush=True)

    def wipe(self) -> None:
        if self._terminal and self._shown > self._started:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)


def watch() -> Progress:
    """Progress for one command; Ctrl-C cancels at the next report, a second one at once."""
    import atexit

    watcher = _Watcher()
    atexit.register(watcher.wipe)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, watcher.ask_to_stop)
    return LiveProgress(watcher.tell, lambda: watcher.stop)
