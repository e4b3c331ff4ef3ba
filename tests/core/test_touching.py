"""Leaves that cross, told apart by their shapes."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.rejoining import rejoin_pieces
from app.core.segments import segment_leaves
from app.core.touching import lay_sheet, part_surface

STEP, SIDE = 4e-4, 120
NOISE = 0.0007


def look(depth, noise=NOISE, seed=3):
    """Points of the depths along the x axis, seen from the origin, with noise along the beams."""
    row, column = np.mgrid[:SIDE, :SIDE]
    side, up = (SIDE / 2 - column) * STEP, (SIDE / 2 - row) * STEP
    beams = np.stack([np.ones_like(side), side, up], axis=-1)
    length = np.linalg.norm(beams, axis=-1)
    ranges = depth * length + noise * np.random.default_rng(seed).standard_normal(depth.shape)
    return (beams / length[..., None] * ranges[..., None]).reshape(-1, 3), row, column


def make_crossing(turn=0.6):
    """Depths of two planes that cross, the nearer one seen; and which it is."""
    column = np.mgrid[:SIDE, :SIDE][1]
    across = (SIDE / 2 - column) * STEP * 2.0
    planes = np.stack([2.0 + np.tan(turn) * across, 2.0 - np.tan(turn) * across])
    return planes.min(axis=0), planes.argmin(axis=0)


def spread_label(parts, size):
    label = np.full(size, -1)
    for number, part in enumerate(parts):
        label[part] = number
    return label


def test_planes_that_cross_are_two():
    depth, truth = make_crossing()
    xyz, row, column = look(depth)
    parts = part_surface(lay_sheet(xyz, row.ravel(), column.ravel()), NOISE, 50)
    assert len(parts) == 2
    label = spread_label(parts, len(xyz))
    same = (label == truth.ravel()).mean()
    assert max(same, 1.0 - same) > 0.97


@pytest.mark.parametrize(
    ("curvature", "height"), [(0.0, 0.0), (14.0, 0.0), (0.0, 0.002), (-10.0, 0.0015)]
)
def test_a_bent_or_wrinkled_leaf_is_one(curvature, height):
    row, column = np.mgrid[:SIDE, :SIDE]
    x, y = (SIDE / 2 - column) * STEP * 2.0, (SIDE / 2 - row) * STEP * 2.0
    depth = 2.0 + 0.5 * curvature * x**2 + height * np.sin(x / 0.004) * np.sin(y / 0.005)
    xyz, row, column = look(depth)
    assert len(part_surface(lay_sheet(xyz, row.ravel(), column.ravel()), NOISE, 50)) == 1


def test_waves_of_one_leaf_are_not_shared_out():
    """Crests and valleys fit two surfaces better than one; they lie in stripes."""
    column = np.mgrid[:SIDE, :SIDE][1]
    depth = 2.0 + 0.0035 * np.sign(np.sin(column / 6.0))
    xyz, row, column = look(depth)
    assert len(part_surface(lay_sheet(xyz, row.ravel(), column.ravel()), NOISE, 50)) == 1


def test_three_in_a_chain():
    column = np.mgrid[:SIDE, :SIDE][1]
    across = (SIDE / 2 - column) * STEP * 2.0
    tilts = (0.9, -0.2, -1.4)
    planes = [2.0 + tilt * (across - at) for tilt, at in zip(tilts, (0.02, 0, -0.02), strict=True)]
    truth = np.digitize(column, [40, 80])
    depth = np.choose(truth, planes)
    xyz, row, column = look(depth)
    parts = part_surface(lay_sheet(xyz, row.ravel(), column.ravel()), NOISE, 50)
    assert len(parts) == 3
    label = spread_label(parts, len(xyz))
    for number in range(3):
        own = label[truth.ravel() == number]
        assert np.bincount(own).max() > 0.9 * len(own)


def test_crossing_leaves_of_a_scan():
    """Two leaves cross before a wall: the segments are the leaves."""
    depth, truth = make_crossing(0.8)
    row, column = np.mgrid[:SIDE, :SIDE]
    wall = (row < 20) | (row >= 100) | (column < 15) | (column >= 105)
    xyz, row, column = look(np.where(wall, 4.0, depth))
    grid = SimpleNamespace(rows=SIDE, columns=SIDE, row=row.ravel(), column=column.ravel())
    label = segment_leaves(xyz, np.zeros(3), grid, largest=0.3)
    assert set(np.unique(label)) == {-1, 0, 1}
    leaf = ~wall.ravel()
    same = ((label == truth.ravel()) & leaf).sum() / leaf.sum()
    swapped = ((label == 1 - truth.ravel()) & leaf).sum() / leaf.sum()
    assert max(same, swapped) > 0.95


@pytest.mark.parametrize(("behind", "pieces"), [(0.0, 1), (0.01, 2)])
def test_pieces_of_one_surface_are_rejoined(behind, pieces):
    column = np.mgrid[:SIDE, :SIDE][1]
    depth = 2.0 + 0.3 * (column - 60) * STEP * 2.0 + np.where(column > 62, behind, 0.0)
    xyz, row, column = look(depth)
    label = np.select([column < 58, column > 62], [0, 1], -1).ravel()
    meeting = np.tile([0, 1], (SIDE, 1))
    rejoin_pieces(xyz, row.ravel(), column.ravel(), label, meeting, NOISE)
    assert len(np.unique(label[label >= 0])) == pieces
    rejoin_pieces(xyz, row.ravel(), column.ravel(), label, np.empty((0, 2), int), NOISE)
