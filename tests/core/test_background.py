"""Scraps of walls are told by the wall's plane; leaves before it, and bent ground, are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.background import find_scraps
from app.core.neighbours.steps import Cells
from app.core.segments import SMALLEST, segment_leaves

NOISE = 0.001


def _scene(seed=0, bend=0.0):
    """A wall (surface 0) tilted to the axes, a scrap of it (1), a leaf before it (2)."""
    random = np.random.default_rng(seed)
    wall = random.uniform(-1.0, 1.0, (5000, 2))
    scrap = random.uniform(0.0, 0.1, (400, 2)) + 1.2
    leaf = random.uniform(-0.03, 0.03, (400, 2))
    flat = np.concatenate([wall, scrap, leaf])
    depth = bend * (flat**2).sum(axis=1) + random.normal(0.0, NOISE, len(flat))
    depth[5400:] -= 0.05
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    label = np.repeat([0, 1, 2], [5000, 400, 400])
    return np.column_stack([flat, depth]) @ turn + 3.0, label


@given(st.integers(0, 50))
def test_a_scrap_lies_in_the_plane_of_its_wall(seed):
    xyz, label = _scene(seed)
    assert find_scraps(xyz, label, label == 0, NOISE).tolist() == [False, True, False]


def test_ground_that_bends_has_no_plane():
    xyz, label = _scene(bend=0.3)
    assert not find_scraps(xyz, label, label == 0, NOISE).any()


def test_without_large_surfaces_nothing_is_a_scrap():
    xyz, label = _scene()
    assert not find_scraps(xyz, label, np.zeros(len(label), bool), NOISE).any()
    assert find_scraps(xyz, np.full(len(xyz), -1), label == 0, NOISE).shape == (0,)


@pytest.mark.parametrize(("side", "found"), [(0.004, 0), (0.03, 1)])
def test_bits_smaller_than_a_leaf_are_none_however_fine_the_scan(side, found):
    row, column = (a.ravel() for a in np.mgrid[:220, :220])
    y, z = (column - 110) * 1e-4, (row - 110) * 1e-4
    on = (np.abs(y) < side / 2) & (np.abs(z) < side / 2)
    xyz = np.stack([np.where(on, 1.0, np.nan), y, z], axis=1)
    label = segment_leaves(xyz, np.zeros(3), Cells(220, 220, row, column))
    assert on.sum() > 1000
    assert (side**2 > SMALLEST) == bool(found)
    assert label.max() + 1 == found
