"""Progress and cancel without Qt; the null object costs nothing."""

from __future__ import annotations

from collections.abc import Callable

from app.core.errors import Cancelled


class Progress:
    """Null object: reports to nobody and is never cancelled.

    Long work calls `report` at least every 0.2 s, so that cancel is quick.
    """

    def report(self, fraction: float, text: str = "") -> None:
        """Say how far the work is (0 to 1); raise `Cancelled` when asked to stop."""

    def part(self, start: float, stop: float) -> Progress:
        """Give a progress whose 0 to 1 is `start` to `stop` of this one."""
        return self


class LiveProgress(Progress):
    """Progress that calls a listener and can be cancelled.

    Parameters
    ----------
    listen : callable
        Called with (fraction, text), in the thread that does the work.
    cancelled : callable
        Says whether the user asked to stop.
    """

    def __init__(
        self,
        listen: Callable[[float, str], None],
        cancelled: Callable[[], bool] = lambda: False,
        span: tuple[float, float] = (0.0, 1.0),
    ) -> None:
        self._listen = listen
        self._cancelled = cancelled
        self._span = span

    def report(self, fraction: float, text: str = "") -> None:
        if self._cancelled():
            raise Cancelled
        start, stop = self._span
        self._listen(start + (stop - start) * min(max(fraction, 0.0), 1.0), text)

    def part(self, start: float, stop: float) -> Progress:
        low, high = self._span
        width = high - low
        return LiveProgress(
            self._listen, self._cancelled, (low + width * start, low + width * stop)
        )


QUIET = Progress()
