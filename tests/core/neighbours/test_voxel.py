"""Voxel sorting and cropping keep every neighbour."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.core.neighbours.voxel import PIECE, crop_to, sort_voxels, usable_points


def test_crop_keeps_all_neighbours_of_far_apart_points():
    rng = np.random.default_rng(0)
    xyz = rng.uniform(0, 1, (20_000, 3)) * [10.0, 10.0, 0.05]
    xyz[5] = np.nan
    asked = np.array([10, 11, 19_000])
    kept = crop_to(xyz, np.array([5.0, 5.0, 3.0]), asked, 0.2)
    finite = np.flatnonzero(np.isfinite(xyz).all(axis=1))
    needed = {int(finite[k]) for p in asked for k in
              cKDTree(xyz[finite]).query_ball_point(xyz[p], 0.2)}  # fmt: skip
    assert needed <= set(kept.tolist())
    assert len(kept) < 0.1 * len(xyz)


def test_voxels_hold_each_point_once_and_far_outliers_do_no_harm():
    rng = np.random.default_rng(1)
    xyz = rng.normal(0, 0.02, (1000, 3))
    xyz[3] = 1e9
    sorted_ = sort_voxels(xyz, np.arange(1000), 0.004)
    assert np.array_equal(np.sort(sorted_.member), np.arange(1000))
    assert (np.diff(sorted_.keys) > 0).all()
    assert sorted_.start[-1] == 1000
    voxel = np.floor((xyz - np.median(xyz, axis=0)) / 0.004)
    inside = np.delete(np.arange(1000), 3)
    assert len(sorted_.keys) == len(np.unique(voxel[inside], axis=0)) + 1


def test_sorting_in_parts_is_sorting():
    rng = np.random.default_rng(2)
    xyz = rng.uniform(-1, 1, (2 * PIECE + 11, 3)) * [1.0, 0.3, 0.02]
    points = np.flatnonzero(rng.random(len(xyz)) < 0.9)
    sorted_ = sort_voxels(xyz, points, 0.05)
    keys = np.repeat(sorted_.keys, np.diff(sorted_.start))
    assert (np.diff(sorted_.keys) > 0).all()
    assert np.array_equal(np.sort(sorted_.member), points)
    inside = np.diff(keys) == 0
    assert (np.diff(sorted_.member)[inside] > 0).all()  # a voxel keeps the scan's order
    for axis, values in enumerate((sorted_.x, sorted_.y, sorted_.z)):
        assert np.array_equal(values, xyz[sorted_.member, axis])
        low = np.minimum.reduceat(values, sorted_.start[:-1])
        high = np.maximum.reduceat(values, sorted_.start[:-1])
        assert (high - low).max() <= 0.05


def test_points_without_range_are_not_usable():
    scanner = np.array([1.0, 2.0, 3.0])
    xyz = np.array([[1.0, 2.0, 3.0], [1, 2, 3.5], [np.nan, 0, 0], [0, np.inf, 0], [0, 0, 0]])
    assert usable_points(xyz, scanner).tolist() == [1, 4]
