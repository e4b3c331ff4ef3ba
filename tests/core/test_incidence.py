"""Local planes against analytic truth and against a k-d tree with numpy's eigen solver."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from app.core.ball import ENOUGH, FACTORS
from app.core.errors import Cancelled, WrongUse
from app.core.incidence import incidence_angle
from app.core.incidence import local_planes as planes_by
from app.core.progress import LiveProgress

ORIGIN = np.zeros(3)
local_planes = partial(planes_by, estimator="ball")


def make_plane_scan(tilt, rows=60, columns=70, step=(3e-4, 3e-4), noise=0.0, distance=2.0):
    """A plane through (distance, 0, 0), turned by `tilt` about z, on a spherical grid."""
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    elevation, azimuth = (row - rows / 2) * step[0], (column - columns / 2) * step[1]
    beams = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    normal = np.array([-np.cos(tilt), np.sin(tilt), 0.0])
    ranges = -distance * np.cos(tilt) / (beams @ normal)
    ranges = ranges + np.random.default_rng(0).normal(0, noise, len(ranges))
    grid = SimpleNamespace(rows=rows, columns=columns, row=row, column=column)
    return beams * ranges[:, None], grid, normal


def exact_widths(planes, radius=0.004):
    """The widths as they were before they were rounded to single precision."""
    step = np.searchsorted(FACTORS * radius * (1 - 1e-6), planes.width) - 1
    assert np.allclose(planes.width, FACTORS[step] * radius, rtol=1e-7)
    return FACTORS[step] * radius


def fit_by_tree(xyz, scanner, planes, asked):
    """Normals from a k-d tree's balls of the widths used; NaN where the plane is not sharp."""
    tree = cKDTree(np.nan_to_num(xyz, nan=1e9))
    normals, widths = np.full((len(asked), 3), np.nan), exact_widths(planes)
    for k, p in enumerate(asked):
        near = tree.query_ball_point(xyz[p], widths[k])
        assert len(near) == planes.count[k]
        offsets = xyz[near] - xyz[p]
        offsets = offsets - offsets.mean(axis=0)
        values, vectors = np.linalg.eigh(offsets.T @ offsets)
        if len(near) >= 3 and values[1] > 10 * values[0]:
            normals[k] = vectors[:, 0]
    return normals


@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0, 80.0])
@pytest.mark.parametrize("on_grid", [True, False])
def test_plane_at_known_angle(degrees, on_grid):
    xyz, grid, normal = make_plane_scan(np.deg2rad(degrees))
    planes = local_planes(xyz, ORIGIN, grid=grid if on_grid else None)
    assert planes.method == ("scan grid" if on_grid else "voxel hash")
    assert planes.normals @ normal == pytest.approx(1.0, abs=1e-9)
    truth = np.arccos(np.abs(xyz @ normal) / np.linalg.norm(xyz, axis=1))
    angle = incidence_angle(xyz, planes.normals, ORIGIN)
    assert np.abs(np.rad2deg(angle - truth)).max() < 2e-6
    assert planes.rms.max() < 1e-9


@pytest.mark.parametrize("on_grid", [True, False])
@pytest.mark.parametrize("step", [(3e-4, 3e-4), (4e-4, 1.6e-3), (2e-3, 5e-4)])
def test_equals_brute_force(on_grid, step):
    xyz, grid, _ = make_plane_scan(0.7, rows=50, columns=50, step=step, noise=0.0007)
    rng = np.random.default_rng(1)
    xyz[rng.random(len(xyz)) < 0.2] = np.nan
    xyz[rng.random(len(xyz)) < 0.02] *= 0.9
    finite = np.flatnonzero(np.isfinite(xyz).all(axis=1))
    asked = finite[:: len(finite) // 300]
    planes = local_planes(xyz, ORIGIN, asked, grid=grid if on_grid else None)
    normals = fit_by_tree(xyz, ORIGIN, planes, asked)
    expected = incidence_angle(xyz[asked], normals, ORIGIN)
    angle = incidence_angle(xyz[asked], planes.normals, ORIGIN)
    sharp = np.isfinite(expected) & np.isfinite(angle)
    assert np.isfinite(angle).mean() > 0.97
    assert sharp.sum() > 100
    assert np.rad2deg(np.abs(angle - expected)[sharp]).max() < 1e-6


def test_grid_and_voxels_agree_over_the_seam_and_at_the_pole():
    rows, columns = 40, 200
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    elevation = np.pi / 2 - 0.004 * row
    azimuth = 2 * np.pi * column / columns
    rng = np.random.default_rng(2)
    xyz = (0.1 + rng.normal(0, 1e-5, len(row)))[:, None] * np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    grid = SimpleNamespace(rows=rows, columns=columns, row=row, column=column)
    on_grid = local_planes(xyz, ORIGIN, radius=0.001, grid=grid)
    by_voxels = local_planes(xyz, ORIGIN, radius=0.001)
    assert on_grid.method == "scan grid"
    assert np.array_equal(on_grid.count, by_voxels.count)


def test_sphere_faces_the_scanner():
    xyz, grid, _ = make_plane_scan(0.0, rows=80, columns=80)
    beams = xyz / np.linalg.norm(xyz, axis=1)[:, None]
    centre, radius = np.array([2.0, 0.0, 0.0]), 0.1
    along = beams @ centre
    ranges = along - np.sqrt(along**2 - centre @ centre + radius**2)
    ball = beams * ranges[:, None]
    planes = local_planes(ball, ORIGIN, radius=0.002, grid=grid)
    outwards = (ball - centre) / radius
    inner = (grid.row > 5) & (grid.row < 74) & (grid.column > 5) & (grid.column < 74)
    assert ((planes.normals * outwards).sum(axis=1)[inner] > np.cos(np.deg2rad(0.5))).all()


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([0.0, 1e3, 1e6]), st.booleans())
def test_turning_and_moving_everything_changes_no_angle(seed, offset, on_grid):
    xyz, grid, _ = make_plane_scan(0.6, rows=20, columns=20, noise=0.0007)
    chosen = grid if on_grid else None
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    scanner = offset * rng.uniform(-1, 1, 3)
    moved = xyz @ turn.T + scanner
    before = local_planes(xyz, ORIGIN, grid=chosen)
    # A neighbour on the rim of the ball may fall on either side after rounding.
    after = local_planes(moved, scanner, grid=chosen)
    same = before.count == after.count
    assert same.mean() > 0.9
    a = incidence_angle(xyz, before.normals, ORIGIN)
    b = incidence_angle(moved, after.normals, scanner)
    change = np.rad2deg(np.abs(a - b)[same])
    # At 10⁶ m a coordinate is rounded by 10⁻¹⁰ m, which alone turns a 4 mm plane by 10⁻⁶ °.
    assert np.median(change) < 1e-6
    assert change.max() < (1e-5 if offset == 1e6 else 1e-6)


@pytest.mark.parametrize("on_grid", [True, False])
def test_subset_equals_full(on_grid):
    xyz, grid, _ = make_plane_scan(1.2, rows=120, columns=90, noise=0.0007)
    xyz[::17] = np.nan
    chosen = grid if on_grid else None
    full = local_planes(xyz, ORIGIN, grid=chosen)
    points = np.array([8000, 4, 17, 4, 5003, 9999])
    part = local_planes(xyz, ORIGIN, points, grid=chosen)
    assert np.array_equal(part.count, full.count[points])
    assert np.array_equal(part.width, full.width[points])
    assert np.allclose(part.normals, full.normals[points], atol=1e-12, equal_nan=True)
    assert np.isnan(part.normals[2]).all()


@pytest.mark.parametrize("on_grid", [True, False])
def test_ball_grows_until_it_holds_enough(on_grid):
    xyz, grid, normal = make_plane_scan(0.5, step=(1.2e-3, 4.4e-3), distance=5.0)
    planes = local_planes(xyz, ORIGIN, grid=grid if on_grid else None)
    inner = (grid.row > 9) & (grid.row < 50) & (grid.column > 9) & (grid.column < 60)
    assert (planes.count[inner] >= ENOUGH).all()
    assert (planes.width[inner] > 0.004).all()
    tree, widths = cKDTree(xyz), exact_widths(planes)
    for p in np.flatnonzero(inner)[::200]:
        step = np.searchsorted(FACTORS * 0.004, widths[p])
        before = tree.query_ball_point(xyz[p], 0.004 * FACTORS[step - 1])
        assert len(before) < ENOUGH or len(np.unique(grid.column[before])) == 1
        assert len(np.unique(grid.column[tree.query_ball_point(xyz[p], widths[p])])) > 1
    assert planes.normals[inner] @ normal == pytest.approx(1.0, abs=1e-9)


def test_noise_on_one_column_is_no_plane():
    """Columns too far apart even for the largest ball: nothing is known, not 90 degrees."""
    xyz, grid, _ = make_plane_scan(0.5, step=(1e-3, 3e-2), columns=20, noise=0.002)
    planes = local_planes(xyz, ORIGIN, grid=grid)
    assert planes.method == "scan grid"
    assert np.isnan(planes.normals).all()
    assert (planes.count > ENOUGH).all()


@pytest.mark.parametrize("on_grid", [True, False])
def test_points_without_a_plane_are_nan(on_grid):
    row, column = (a.ravel() for a in np.mgrid[:8, :8])
    xyz = np.stack([np.full(64, 2.0), column * 1e-3, row * 1e-3], axis=1)
    grid = SimpleNamespace(rows=8, columns=8, row=row, column=column)
    xyz[row != 3] = np.nan  # one row of points: a line
    xyz[0] = np.inf
    xyz[1] = 0.0
    planes = local_planes(xyz, ORIGIN, grid=grid if on_grid else None)
    assert np.isnan(planes.normals).all()
    assert np.isnan(planes.rms).all()
    assert (planes.width[row != 3] == 0.0).all()
    assert (planes.count[row == 3] > 3).all()


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_points(count):
    xyz = np.array([[2.0, 0.0, 0.0], [2.0, 0.001, 0.0]])[:count]
    planes = local_planes(xyz, ORIGIN)
    assert np.isnan(planes.normals).all()
    assert planes.normals.shape == (count, 3)


def test_duplicates_have_no_plane_of_their_own():
    xyz = np.repeat([[2.0, 0.0, 0.0]], 9, axis=0)
    assert np.isnan(local_planes(xyz, ORIGIN).normals).all()


def test_several_returns_per_cell():
    xyz, grid, normal = make_plane_scan(0.3)
    behind = xyz * 1.5
    both = np.concatenate([xyz, behind])
    grid.row, grid.column = np.tile(grid.row, 2), np.tile(grid.column, 2)
    planes = local_planes(both, ORIGIN, grid=grid)
    assert planes.method == "scan grid"
    assert planes.normals @ normal == pytest.approx(1.0, abs=1e-9)


def test_unusable_grid_falls_back_and_says_why():
    xyz, grid, normal = make_plane_scan(0.3)
    order = np.random.default_rng(0).permutation(len(xyz))
    planes = local_planes(xyz[order], ORIGIN, grid=grid)
    assert planes.method == "voxel hash"
    assert "do not follow" in planes.reason
    assert planes.normals @ normal == pytest.approx(1.0, abs=1e-9)


def test_incidence_is_exact_near_zero():
    normal = np.array([[0.0, 0.0, 1.0]])
    angle = incidence_angle(np.array([[1e-9, 0.0, -1.0]]), normal, ORIGIN)
    assert angle[0] == pytest.approx(1e-9, rel=1e-6)
    assert np.isnan(incidence_angle(np.zeros((1, 3)), normal, ORIGIN)[0])


def test_wrong_use_and_cancel():
    xyz, grid, _ = make_plane_scan(0.3, rows=10, columns=10)
    with pytest.raises(WrongUse, match="radius"):
        local_planes(xyz, ORIGIN, radius=0.0)
    with pytest.raises(WrongUse, match="Point 100"):
        local_planes(xyz, ORIGIN, np.array([100]))
    stop = LiveProgress(lambda *_: None, lambda: True)
    for chosen in (grid, None):
        with pytest.raises(Cancelled):
            local_planes(xyz, ORIGIN, grid=chosen, progress=stop)
