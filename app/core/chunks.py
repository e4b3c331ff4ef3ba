"""Long loops in pieces: several threads, and a cancel that is quick."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from app.core.arrays import Ints
from app.core.progress import QUIET, Progress

CHUNK = 50_000


def count_processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def split_evenly(total: int, size: int = CHUNK) -> Ints:
    """Borders of pieces of about `size` out of `total`: 0, …, total."""
    return np.linspace(0, total, max(1, -(-total // size)) + 1).astype(np.int64)


def run_in_pieces(
    work: Callable[[int, int], None], borders: Ints, progress: Progress = QUIET, text: str = ""
) -> None:
    """Call `work(first, last)` for each piece, in threads; `work` must release the lock.

    Raises
    ------
    Cancelled
        From `progress`, between pieces; those not yet begun are dropped.
    """
    pieces = [(int(first), int(last)) for first, last in pairwise(borders) if last > first]
    progress.report(0.0, text)
    if len(pieces) == 1:  # starting threads takes longer than most single pieces
        work(*pieces[0])
        progress.report(1.0, text)
        return
    with ThreadPoolExecutor(min(count_processors(), max(1, len(pieces)))) as pool:
        try:
            for done, _ in enumerate(pool.map(lambda piece: work(*piece), pieces), start=1):
                progress.report(done / len(pieces), text)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
