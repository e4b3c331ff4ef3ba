"""Leaves as connected surfaces."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import Cancelled, WrongUse
from app.core.progress import LiveProgress
from app.core.segments import segment_leaves

ORIGIN = np.zeros(3)


def make_scene(columns=200, turn=0.0):
    """Two tilted leaves side by side, 6 cm apart in depth, and a speck, before a wall."""
    row, column = (a.ravel() for a in np.mgrid[:120, :columns])
    step = 1e-3
    azimuth = (column - 100) * step + turn
    el = (row - 60) * step
    ranges = np.full(len(row), 3.0)
    truth = np.full(len(row), -1)
    for label, (left, depth) in enumerate(((40, 2.0), (70, 2.12))):
        inside = (column >= left) & (column < left + 30) & (row > 30) & (row < 80)
        ranges[inside] = depth + 0.002 * (column[inside] - left)
        truth[inside] = label
    ranges[(column > 150) & (column < 154) & (row > 50) & (row < 54)] = 1.5
    xyz = ranges[:, None] * np.stack(
        [np.cos(el) * np.cos(azimuth), np.cos(el) * np.sin(azimuth), np.sin(el)], axis=1
    )
    grid = SimpleNamespace(rows=120, columns=columns, row=row, column=column)
    # Labels count in the order of the first points; both begin in row 31.
    return xyz, grid, truth


def test_leaves_on_the_grid():
    xyz, grid, truth = make_scene()
    assert np.array_equal(segment_leaves(xyz, ORIGIN, grid, largest=0.3), truth)


def test_order_of_points_does_not_matter():
    xyz, grid, truth = make_scene()
    order = np.random.default_rng(0).permutation(len(xyz))
    grid.row, grid.column = grid.row[order], grid.column[order]
    labels = segment_leaves(xyz[order], ORIGIN, grid, largest=0.3)
    for label in (0, 1):
        assert len(np.unique(labels[truth[order] == label])) == 1
    assert np.array_equal(labels >= 0, truth[order] >= 0)


def test_leaves_without_grid_or_scanner():
    xyz, _, truth = make_scene()
    order = np.flatnonzero(truth != 1)  # the two leaves touch within a voxel
    labels = segment_leaves(xyz[order], None, None, largest=0.3)
    assert np.array_equal(labels, np.where(truth[order] == 0, 0, -1))


def test_ghosts_and_missing_points_have_no_label():
    xyz, grid, truth = make_scene()
    ghosts = np.zeros(len(xyz), bool)
    ghosts[(grid.column == 55) & (truth == 0)] = True  # cuts the first leaf in two
    xyz[(truth == 1) & (grid.row == 40) & (grid.column == 80)] = np.nan
    labels = segment_leaves(xyz, ORIGIN, grid, largest=0.3, ghosts=ghosts)
    assert labels.max() == 2
    assert (labels[ghosts | np.isnan(xyz[:, 0])] == -1).all()


def test_surfaces_connect_over_the_seam():
    columns = 360
    row, column = (a.ravel() for a in np.mgrid[:40, :columns])
    azimuth, el = 2 * np.pi * column / columns, (row - 20) * 0.0175
    ranges = np.where((column < 10) | (column >= 350), 1.0, 4.0)
    xyz = ranges[:, None] * np.stack(
        [np.cos(el) * np.cos(azimuth), np.cos(el) * np.sin(azimuth), np.sin(el)], axis=1
    )
    grid = SimpleNamespace(rows=40, columns=columns, row=row, column=column)
    labels = segment_leaves(xyz, ORIGIN, grid, largest=1.0)
    assert np.array_equal(labels, np.where(ranges == 1.0, 0, -1))


def test_nothing_and_wrong_use():
    empty = segment_leaves(np.empty((0, 3)), None, None)
    assert empty.shape == (0,)
    xyz, grid, _ = make_scene()
    with pytest.raises(WrongUse, match="jump"):
        segment_leaves(xyz, ORIGIN, grid, jump=0.0)
    with pytest.raises(Cancelled):
        segment_leaves(xyz, ORIGIN, grid, progress=LiveProgress(lambda *_: None, lambda: True))
