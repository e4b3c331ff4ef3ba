"""One choice per scan object, made once, and not kept longer than the scan."""

from __future__ import annotations

import gc
import threading
import weakref

import numpy as np
import pytest

import app.model.neighbours as module
from app.core.errors import Cancelled
from app.core.progress import LiveProgress
from app.model.neighbours import neighbours_of
from app.model.scan import Grid, Pose, Scan


def make_scan(**changes):
    row, column = (a.ravel() for a in np.mgrid[:60, :80])
    rise, turn = 0.1 - 0.001 * row, -0.0012 * column
    beams = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], 1)
    return Scan("s", 3.0 * beams, **{"pose": Pose((0.0, 0.0, 0.0)), **changes})


def test_recovers_without_a_grid_and_takes_one_that_is_there():
    assert neighbours_of(make_scan()).method == "recovered grid"
    zeros = np.zeros(4800, np.int32)
    grid = Grid(1, 1, zeros, zeros)
    known = neighbours_of(make_scan(grid=grid))
    assert (known.method, known.grid) == ("scan grid", grid)


def test_unknown_position_means_voxels():
    chosen = neighbours_of(make_scan(pose=None))
    assert (chosen.method, chosen.grid) == ("voxel hash", None)
    assert "position is unknown" in chosen.reason


def test_threads_share_one_choice(monkeypatch):
    calls = []
    choose = module.choose_neighbours

    def count(*arguments):
        calls.append(1)
        return choose(*arguments)

    monkeypatch.setattr(module, "choose_neighbours", count)
    scan, found = make_scan(), []
    threads = [threading.Thread(target=lambda: found.append(neighbours_of(scan))) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(calls) == 1
    assert len(found) == 6
    assert all(one is found[0] for one in found)


def test_moved_scanner_is_another_choice():
    scan = make_scan()
    moved = scan.with_pose(Pose((0.4, 0.3, 0.2)))
    assert neighbours_of(scan).method == "recovered grid"
    assert neighbours_of(moved) is not neighbours_of(scan)


def test_scan_is_not_kept_alive():
    scan = make_scan()
    neighbours_of(scan)
    gone = weakref.ref(scan)
    del scan
    gc.collect()
    assert gone() is None


def test_cancel_keeps_nothing():
    scan = make_scan()
    with pytest.raises(Cancelled):
        neighbours_of(scan, LiveProgress(lambda *_: None, lambda: True))
    assert neighbours_of(scan).method == "recovered grid"
