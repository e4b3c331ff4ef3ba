"""Pieces cover everything once, and stop soon when asked."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from app.core.chunks import run_in_pieces, split_evenly
from app.core.errors import Cancelled
from app.core.progress import LiveProgress


@pytest.mark.parametrize("total", [0, 1, 99, 100, 101, 1234])
def test_every_item_once(total):
    seen = np.zeros(total, int)
    lock = threading.Lock()

    def work(first, last):
        with lock:
            seen[first:last] += 1
            assert last - first <= 100

    fractions = []
    run_in_pieces(work, split_evenly(total, 100), LiveProgress(lambda f, _: fractions.append(f)))
    assert (seen == 1).all()
    assert fractions == sorted(fractions)


def test_cancel_drops_the_rest():
    done = []

    def work(first, last):
        time.sleep(0.002)
        done.append((first, last))

    progress = LiveProgress(lambda *_: None, lambda: len(done) >= 3)
    with pytest.raises(Cancelled):
        run_in_pieces(work, split_evenly(5000, 10), progress)
    assert 3 <= len(done) < 100


def test_errors_reach_the_caller():
    def fail(first, last):
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        run_in_pieces(fail, split_evenly(100, 10))
