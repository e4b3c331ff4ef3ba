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
RETRY = 0.1
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


class Stop:
    """The wish to stop, said by Ctrl-C or a polite kill."""

    def __init__(self) -> None:
        self._asked = False

    def asked(self) -> bool:
        """Whether somebody wants the program to stop."""
        return self._asked

    def ask(self, _number: int, _frame: FrameType | None) -> None:
        """Raise `Cancelled` where the program stands; from now on a signal kills.

        Python swallows what is raised in a destructor or a callback: then the next report of
        progress finds `asked`, and where there is none a second signal still ends the program.
        """
        self._asked = True
        if _is_compiling() and hasattr(signal, "setitimer"):
            # An exception in the middle of LLVM may crash it, or leave its lock taken for ever.
            signal.signal(signal.SIGALRM, self.ask)
            signal.setitimer(signal.ITIMER_REAL, RETRY)
            self._let_signals_kill()
            return
        # What was half made when the signal came cannot be taken apart, and would say so at length.
        sys.unraisablehook = _keep_quiet
        self._let_signals_kill()
        raise Cancelled

    def _let_signals_kill(self) -> None:
        for number in STOPS:
            signal.signal(number, signal.SIG_DFL)


def _is_compiling() -> bool:
    """Whether a kernel is being compiled; without an import of numba."""
    module = sys.modules.get("numba.core.compiler_lock")
    lock = getattr(module, "global_compiler_lock", None)
    return lock is not None and bool(lock.is_locked())


def _keep_quiet(_unraisable: object) -> None:
    """Say nothing of an exception that Python ignores."""


STOP = Stop()


def watch() -> Progress:
    """Progress of one command."""
    return LiveProgress(LINE.show, STOP.asked)


def cancel_on_signals() -> None:
    """From now on Ctrl-C and a polite kill raise `Cancelled` where the program stands."""
    for number in STOPS:
        signal.signal(number, STOP.ask)
