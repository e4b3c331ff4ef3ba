"""The ready-made scans: what they promise is in them."""

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.simulate.branch import TILTS, build_branch
from app.simulate.scenes import (
    demo_scan,
    large_scan,
    leaf_row_scan,
    leaves_scan,
    plane_scan,
)


@pytest.fixture(scope="module")
def demo():
    return demo_scan(step_deg=0.06)


def test_demo_has_leaves_wall_sky_and_ghosts(demo):
    leaf = demo.attributes["truth_leaf"]
    assert set(np.unique(leaf)) == set(range(-1, 25))
    cells = demo.grid.rows * demo.grid.columns
    assert len(demo) + len(demo.grid.no_return) == cells
    assert 0.1 < len(demo.grid.no_return) / cells < 0.3
    assert 0.01 < (demo.attributes["truth_ghost"] == 1).mean() < 0.15
    assert demo.pose.known_by == "file"
    assert [c.name for c in demo.channels] == ["reflectance_1063", "reflectance_1545"]
    assert demo.valid.all()


def test_demo_at_its_own_step_is_of_the_promised_size(demo):
    coarse = len(demo) * (0.06 / 0.018) ** 2
    assert 300_000 < coarse < 450_000


def test_row_of_the_demo_stands_at_its_tilts(demo):
    for leaf, tilt in enumerate(TILTS):
        mine = demo.attributes["truth_leaf"] == leaf
        assert demo.attributes["truth_incidence"][mine].mean() == pytest.approx(tilt, abs=0.6)


def test_branch_mixes_kinds_and_differs_in_water():
    leaves = build_branch(1).leaves[6:]
    wrinkled = sum(leaf.wrinkle_height > 0 for leaf in leaves)
    flat = sum(leaf.curvature == 0 for leaf in leaves)
    assert (flat, len(leaves) - flat - wrinkled, wrinkled) == (7, 6, 6)
    near, short = (np.std([leaf.material[k].rho for leaf in leaves]) for k in (0, 1))
    assert short > near
    assert all(0.04 <= leaf.width <= 0.06 and 0.06 <= leaf.length <= 0.09 for leaf in leaves)


def test_ghosts_lie_off_every_surface_and_the_rest_on_one(demo):
    distance, ghost = demo.attributes["truth_distance"], demo.attributes["truth_ghost"]
    assert (distance[ghost == 1] > 0.006).all()
    assert (distance[ghost == 0] <= 0.002).all()
    whole = demo.attributes["truth_hit_fraction"] > 0.9999
    assert not ghost[whole].any()
    assert np.abs(demo.attributes["truth_range_shift"][whole]).max() < 0.004


def test_cells_agree_with_directions(demo):
    beam = demo.xyz - np.array(demo.pose.position)
    azimuth = np.arctan2(beam[:, 1], beam[:, 0])
    step = np.deg2rad(0.06)
    np.testing.assert_allclose(azimuth, np.deg2rad(7.7) - step * demo.grid.column, atol=1e-9)
    elevation = np.arctan2(beam[:, 2], np.hypot(beam[:, 0], beam[:, 1]))
    np.testing.assert_allclose(elevation, np.deg2rad(5.0) - step * demo.grid.row, atol=1e-9)


def test_plane_scan_is_framed_by_no_returns_and_refuses_edge_on():
    scan = plane_scan(40)
    assert (scan.attributes["truth_leaf"] == 0).all()
    frame = scan.grid.no_return
    assert frame.min() == 0
    assert frame.max() == scan.grid.rows * scan.grid.columns - 1
    with pytest.raises(WrongUse, match="90"):
        plane_scan(90)


def test_leaf_row_is_exact_without_noise():
    scan = leaf_row_scan(tilts_deg=(0.0, 50.0))
    assert set(np.unique(scan.attributes["truth_leaf"])) == {-1, 0, 1}
    reported = np.linalg.norm(scan.xyz - np.array(scan.pose.position), axis=1)
    np.testing.assert_allclose(reported, scan.attributes["truth_range"], atol=1e-12)


def test_leaves_scan_shows_its_leaves():
    scan = leaves_scan(2, leaves=5, step_deg=0.06)
    assert len(np.unique(scan.attributes["truth_leaf"])) >= 5
    assert scan.attributes["truth_leaf"].max() <= 4


def test_large_scan_is_exact_and_ten_leaves_are_small():
    scan = large_scan(200_000, 3)
    assert len(scan) == pytest.approx(200_000, rel=0.01)
    leaf = scan.attributes["truth_leaf"]
    assert (leaf < 10).mean() - (leaf < 0).mean() < 0.02
    for label in (0, 100, 323):
        patch = scan.xyz[leaf == label]
        _, spread, axes = np.linalg.svd(patch - patch.mean(axis=0), full_matrices=False)
        assert spread[2] < 1e-9
        beam = patch / np.linalg.norm(patch, axis=1)[:, None]
        omega = np.rad2deg(np.arccos(np.abs(beam @ axes[2])))
        np.testing.assert_allclose(
            omega, scan.attributes["truth_incidence"][leaf == label], atol=1e-3
        )
    np.testing.assert_allclose(scan.xyz[leaf == -1, 0], 6.0)
