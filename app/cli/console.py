"""A command's terminal: progress on it, and the cancel by Ctrl-C or a polite kill."""

from __future__ import annotations

import signal
import sys
import time
from typing import TYPE_CHECKING

from app.core.errors import Cancelled
from app.core.progress import LiveProgress, Progress

if TYPE_CHECKING:
    from types import FrameType

PATIENCE = 1.0
INTERVAL = 0.1
STOPS = (signal.SIGINT, signal.SIGTERM)


class ProgressLine:
    """One line on the error stream that is rewritten, if that is a terminal."""

    def __init__(self) -> None:
        self._started = self._shown = time.monotonic()
        self._on_screen = False

    def show(self, fraction: float, text: str) -> None:
        """Rewrite the line, once the work takes longer than a moment."""
        now = time.monotonic()
        patient = now - self._started > PATIENCE and now - self._shown > INTERVAL
        if patient and sys.stderr.isatty():
            self._shown, self._on_screen = now, True
            print(f"\r\x1b[2K{fraction:4.0%} {text}", end="", file=sys.stderr, flush=True)

    def wipe(self) -> None:
        """Take the line away before something else is printed."""
        if self._on_screen:
            self._on_screen = False
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)


LINE = ProgressLine()


def watch() -> Progress:
    """Progress of one command."""
    return LiveProgress(LINE.show)


def cancel_on_signals() -> None:
    """From now on Ctrl-C and a polite kill raise `Cancelled` where the program stands.

    Only the first does: what cleans up afterwards is not to be interrupted.
    """
    for number in STOPS:
        signal.signal(number, _cancel)


def _cancel(_number: int, _frame: FrameType | None) -> None:
    for other in STOPS:
        signal.signal(other, signal.SIG_IGN)
    raise Cancelled
