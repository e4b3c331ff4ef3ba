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
    ghosts[(grid.column == 55) & (truth == 0)] = True  # cuts a leaf that goes on behind
    xyz[(truth == 1) & (grid.row == 40) & (grid.column == 80)] = np.nan
    labels = segment_leaves(xyz, ORIGIN, grid, largest=0.3, ghosts=ghosts)
    gone = ghosts | np.isnan(xyz[:, 0])
    assert np.array_equal(labels, np.where(gone, -1, truth))


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


def make_canvas(step=1e-3, half=0.15):
    """Beams onto a square of ± `half` rad, row by row, with their angles to the side and up."""
    count = round(2 * half / step)
    row, column = (a.ravel() for a in np.mgrid[:count, :count])
    grid = SimpleNamespace(rows=count, columns=count, row=row, column=column)
    return grid, (column + 0.5) * step - half, (row + 0.5) * step - half


def label_ranges(ranges, grid, side, up, **options):
    """Labels of points at these ranges; NaN is a beam without return."""
    beams = np.stack([np.cos(up) * np.cos(side), np.cos(up) * np.sin(side), np.sin(up)], axis=1)
    return segment_leaves(ranges[:, None] * beams, ORIGIN, grid, **options)


@pytest.mark.parametrize("step", [2.5e-3, 1e-3, 0.4e-3])
@pytest.mark.parametrize(("strip", "leaves"), [(0.004, 2), (0.016, 0)])
def test_discs_on_a_thin_strip_are_two_leaves(step, strip, leaves):
    grid, side, up = make_canvas(step, 0.08)
    first, second = (np.hypot(side - at, up) < 0.02 for at in (-0.04, 0.04))
    joint = (np.abs(side) < 0.04) & (np.abs(up) < max(strip / 2 / 2.0, 0.5 * step))
    ranges = np.where(first | second | joint, 2.0, 3.0)
    labels = label_ranges(ranges, grid, side, up, largest=0.2)
    assert labels.max() + 1 == leaves
    for disc in (first, second):
        assert len(np.unique(labels[disc])) == 1
    assert len({int(labels[first][0]), int(labels[second][0])}) == max(leaves, 1)
    assert (labels[ranges == 3.0] == -1).all()


def test_what_fits_a_leaf_is_not_cut():
    grid, side, up = make_canvas()
    leaf = np.hypot(side, up) < 0.02
    stalk = (np.abs(side) < 0.001) & (up > 0) & (up < 0.06)
    labels = label_ranges(np.where(leaf | stalk, 2.0, 3.0), grid, side, up)
    assert np.array_equal(labels, np.where(leaf | stalk, 0, -1))


def test_background_framed_by_a_nearer_ring_is_no_leaf():
    grid, side, up = make_canvas()
    away = np.hypot(side, up)
    ring = (away > 0.03) & (away < 0.1)
    ranges = np.where(ring, 2.0, 3.0)
    assert (label_ranges(ranges, grid, side, up, largest=0.35) == -1).all()
    bird = away < 0.015  # nearer than the ring that surrounds it
    labels = label_ranges(np.where(bird, 1.5, ranges), grid, side, up, largest=0.35)
    assert np.array_equal(labels, np.where(bird, 0, -1))


def test_ghosts_on_the_frame_do_not_hide_it():
    grid, side, up = make_canvas()
    away = np.hypot(side, up)
    ranges = np.where((away > 0.03) & (away < 0.1), 2.0, 3.0)
    ghosts = np.abs(away - 0.03) < 0.0025
    ranges[ghosts] = 2.5
    labels = label_ranges(ranges, grid, side, up, largest=0.35, ghosts=ghosts)
    assert (labels == -1).all()


def test_edge_on_leaf_stays():
    grid, side, up = make_canvas()
    strip = (np.abs(side) < 0.003) & (np.abs(up) < 0.02)  # 6 cells wide
    ranges = np.where(strip, 2.0 + 5.0 * side, 3.0)
    assert np.array_equal(label_ranges(ranges, grid, side, up), np.where(strip, 0, -1))


@pytest.mark.parametrize("behind", [3.0, np.nan])
def test_partly_hidden_leaf_stays(behind):
    grid, side, up = make_canvas()
    leaf = np.hypot(side, up) < 0.025
    ranges = np.where(leaf, 2.0, behind)
    ranges[side < 0.0] = 1.0  # hides half of it, and is too large for a leaf
    labels = label_ranges(ranges, grid, side, up, largest=0.2)
    assert np.array_equal(labels, np.where(leaf & (side >= 0.0), 0, -1))


def test_leaf_in_a_slit_shows_what_is_behind_it():
    grid, side, up = make_canvas()
    slit = (np.abs(side) < 0.01) & (np.abs(up) < 0.03)
    leaf = slit & (up > -0.024)  # below it, a seventh of its border, the wall
    ranges = np.where(leaf, 2.0, np.where(slit, 3.0, 1.0))
    labels = label_ranges(ranges, grid, side, up, largest=0.25)
    assert np.array_equal(labels, np.where(leaf, 0, -1))


def test_leaf_is_cut_off_over_the_seam():
    columns = 360
    row, column = (a.ravel() for a in np.mgrid[:40, :columns])
    side, up = np.deg2rad(column), (row - 20) * 0.0175
    leaf = ((column < 8) | (column >= 352)) & (row > 8) & (row < 30)
    board = (column > 40) & (column < 120)
    stalk = (column >= 8) & (column <= 40) & (row == 20)
    grid = SimpleNamespace(rows=40, columns=columns, row=row, column=column)
    ranges = np.where(leaf | board | stalk, 1.0, 4.0)
    labels = label_ranges(ranges, grid, side, up, largest=0.6)
    assert (labels[leaf] == 0).all()
    assert (labels >= 0).sum() <= leaf.sum() + 1  # and the cell where the stalk begins


def test_nothing_and_wrong_use():
    empty = segment_leaves(np.empty((0, 3)), None, None)
    assert empty.shape == (0,)
    xyz, grid, _ = make_scene()
    with pytest.raises(WrongUse, match="jump"):
        segment_leaves(xyz, ORIGIN, grid, jump=0.0)
    with pytest.raises(Cancelled):
        segment_leaves(xyz, ORIGIN, grid, progress=LiveProgress(lambda *_: None, lambda: True))


def test_a_rolled_leaf_is_no_clump():
    """Half of a tube of 3 cm is as deep as a clump, but smooth; the same depth at random is one."""
    row, column = (a.ravel() for a in np.mgrid[:120, :120])
    side, up = (column - 60) * 5e-4, (row - 60) * 5e-4
    beams = np.stack([np.ones(len(row)), side, up], axis=1)
    leaf = (np.abs(side) * 2.0 < 0.0148) & (np.abs(up) * 2.0 < 0.025)
    depth = np.where(leaf, 2.0 - np.sqrt(np.maximum(0.015**2 - (2.0 * side) ** 2, 0.0)), 4.0)
    grid = SimpleNamespace(rows=120, columns=120, row=row, column=column)
    labels = segment_leaves(beams * depth[:, None], ORIGIN, grid, largest=0.3)
    assert np.array_equal(labels, np.where(leaf, 0, -1))
    wood = np.random.default_rng(3).uniform(-0.03, 0.0, len(row))
    depth = np.where(leaf, 2.0 + wood, 4.0)
    labels = segment_leaves(beams * depth[:, None], ORIGIN, grid, jump=0.04, largest=0.3)
    assert (labels == -1).all()
