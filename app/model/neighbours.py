"""How neighbours are found in each scan: looked for once, and forgotten with the scan."""

from __future__ import annotations

import threading
import weakref

from app.core.neighbours.choice import Neighbours, choose_neighbours
from app.core.progress import QUIET, Progress
from app.model.scan import Scan


class _Held:
    """The choice for one scan; who comes second waits for the first."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.neighbours: Neighbours | None = None


_held: weakref.WeakKeyDictionary[Scan, _Held] = weakref.WeakKeyDictionary()
_lock = threading.Lock()


def neighbours_of(scan: Scan, progress: Progress = QUIET) -> Neighbours:
    """How neighbours are found in a scan, chosen when first asked for.

    A scan never changes and is known by identity, so what was found stays true.

    Raises
    ------
    Cancelled
        Nothing is kept; the next call begins anew.
    """
    with _lock:
        held = _held.setdefault(scan, _Held())
    with held.lock:
        if held.neighbours is None:
            scanner = None if scan.pose is None else scan.scanner("the recovery of its grid")
            held.neighbours = choose_neighbours(scan.xyz, scanner, scan.grid, progress)
        return held.neighbours
