"""Voxel sorting and cropping keep every neighbour."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.core.neighbours.voxel import crop_to, sort_voxels


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
