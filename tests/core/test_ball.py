"""Balls on the grid and in voxels: the same neighbours and planes, at any size and place."""

from __future__ import annotations

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from app.core.ball import ENOUGH, FACTORS, fit_balls
from app.core.incidence import incidence_angle, warm_up
from app.core.kernels.ball_tiles import LAYERS, TILE
from app.core.neighbours.asked import as_points
from app.core.neighbours.steps import as_cells
from app.core.progress import QUIET

ORIGIN = np.zeros(3)
RADIUS = 0.004


def make_leaves(rows=150, columns=130, step=4e-4, noise=7e-4, seed=0):
    """Tilted patches at several depths, holes between them, single returns far off."""
    rng = np.random.default_rng(seed)
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    elevation, azimuth = (row - rows / 2) * step, (column - columns / 2) * step
    beams = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    patch = row // 40 * 7 + column // 40
    normals = rng.normal(size=(patch.max() + 1, 3)) * [0.3, 1, 1] - [1.5, 0, 0]
    centres = beams[(row // 40 * 40 + 20).clip(0, rows - 1) * columns + column // 40 * 40]
    distance = rng.uniform(2.0, 5.0, patch.max() + 1)[patch]
    ranges = distance * (centres * normals[patch]).sum(1) / (beams * normals[patch]).sum(1)
    ranges += rng.normal(0, noise, len(row))
    ranges[rng.random(len(row)) < 0.02] *= 0.97
    kept = (rng.random(len(row)) > 0.1) & ((row + column) % 40 > 3)
    grid = SimpleNamespace(rows=rows, columns=columns, row=row[kept], column=column[kept])
    return beams[kept] * ranges[kept, None], grid


def fit(xyz, grid, scanner=ORIGIN, asked=None, radius=RADIUS):
    cells = None if grid is None else as_cells(grid)
    return fit_balls(as_points(xyz), scanner, cells, asked, radius, QUIET)


def degrees(xyz, planes, scanner=ORIGIN):
    return np.rad2deg(incidence_angle(xyz, planes.normals, scanner))


def test_grid_and_voxels_find_the_same():
    xyz, grid = make_leaves()
    on_grid, by_voxels = fit(xyz, grid), fit(xyz, None)
    assert (on_grid.method, by_voxels.method) == ("scan grid", "voxel hash")
    same = np.isclose(on_grid.width, by_voxels.width)
    assert same.mean() > 0.97  # a window has a largest size, a voxel has none
    assert (on_grid.width < by_voxels.width)[~same].all()
    assert np.array_equal(on_grid.count[same], by_voxels.count[same])
    change = np.abs(degrees(xyz, on_grid) - degrees(xyz, by_voxels))[same]
    assert np.nanmax(change) < 1e-6
    assert np.array_equal(np.isnan(on_grid.rms[same]), np.isnan(by_voxels.rms[same]))
    assert (on_grid.count.dtype, on_grid.width.dtype) == (np.int32, np.float32)


@pytest.mark.parametrize("on_grid", [True, False])
def test_equals_brute_force_where_balls_grow(on_grid):
    xyz, grid = make_leaves(step=9e-4)
    planes = fit(xyz, grid if on_grid else None)
    grown = FACTORS * RADIUS
    step = np.abs(planes.width[:, None] - grown).argmin(axis=1)
    assert set(step) >= {0, 1, 2, 3}
    tree = cKDTree(xyz)
    checked = 0
    for p in np.random.default_rng(1).permutation(len(xyz))[:1500]:
        near = tree.query_ball_point(xyz[p], grown[step[p]])
        assert len(near) == planes.count[p]
        offsets = xyz[near] - xyz[p]
        offsets -= offsets.mean(axis=0)
        values, vectors = np.linalg.eigh(offsets.T @ offsets)
        if len(near) >= ENOUGH and values[1] > 10 * values[0] and values[1] > 1e-6 * values[2]:
            one = SimpleNamespace(normals=np.stack([planes.normals[p], vectors[:, 0]]))
            angles = degrees(xyz[[p, p]], one)
            assert abs(angles[0] - angles[1]) < 1e-6
            checked += 1
    assert checked > 300


@pytest.mark.parametrize("on_grid", [True, False])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_size_of_the_scene_does_not_matter(scale, on_grid):
    xyz, grid = make_leaves(rows=60, columns=60)
    chosen = grid if on_grid else None
    before, after = fit(xyz, chosen), fit(xyz * scale, chosen, radius=RADIUS * scale)
    same = before.count == after.count  # rounding moves points over the rim
    assert same.mean() > 0.99
    change = np.abs(degrees(xyz, before) - degrees(xyz * scale, after))[same]
    assert np.nanmax(change) < 1e-6
    expected = before.rms[same] * scale
    assert np.allclose(expected, after.rms[same], rtol=1e-5, atol=1e-8 * scale, equal_nan=True)


@pytest.mark.parametrize("on_grid", [True, False])
@pytest.mark.parametrize(("offset", "most"), [(1e3, 1e-6), (1e5, 1e-6), (1e6, 1e-6), (1e7, 2e-5)])
def test_place_of_the_scene_does_not_matter(offset, most, on_grid):
    """Against the same rounded coordinates, moved back without a further rounding."""
    xyz, grid = make_leaves(rows=60, columns=60)
    chosen = grid if on_grid else None
    place = offset * np.array([1.0, -1.0, 1.0])
    moved = xyz + place
    back = moved - place
    assert np.array_equal(back + place, moved)
    near, far = fit(back, chosen), fit(moved, chosen, scanner=place)
    assert np.array_equal(near.count, far.count)
    change = np.abs(degrees(back, near) - degrees(moved, far, place))
    assert np.nanmax(change) <= most
    assert np.mean(np.isnan(change) & ~np.isnan(degrees(back, near))) < 0.001


@pytest.mark.parametrize("returns", [2, LAYERS, LAYERS + 2])
def test_several_returns_per_cell(returns):
    xyz, grid = make_leaves(rows=40, columns=TILE + 30)
    behind = np.concatenate([xyz * (1 + 0.0004 * k) for k in range(returns)])
    grid.row, grid.column = np.tile(grid.row, returns), np.tile(grid.column, returns)
    on_grid, by_voxels = fit(behind, grid), fit(behind, None)
    assert on_grid.method == "scan grid"
    same = np.isclose(on_grid.width, by_voxels.width)
    assert same.mean() > 0.97
    assert np.array_equal(on_grid.count[same], by_voxels.count[same])
    assert np.nanmax(np.abs(degrees(behind, on_grid) - degrees(behind, by_voxels))[same]) < 1e-6


@pytest.mark.parametrize("columns", [90, 200])
def test_ring_around_the_scanner(columns):
    """Tiles reach over the seam; round a narrow ring a tile would meet itself."""
    row, column = (a.ravel() for a in np.mgrid[:50, :columns])
    azimuth, elevation = 2 * np.pi * column / columns, (row - 25) * np.pi / columns
    beams = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    xyz = beams * (0.1 + np.random.default_rng(3).normal(0, 1e-4, len(row)))[:, None]
    grid = SimpleNamespace(rows=50, columns=columns, row=row, column=column)
    for radius in (0.02, 0.04):
        on_grid, by_voxels = fit(xyz, grid, radius=radius), fit(xyz, None, radius=radius)
        assert on_grid.method == "scan grid"
        assert np.array_equal(on_grid.count, by_voxels.count)
        assert np.nanmax(np.abs(degrees(xyz, on_grid) - degrees(xyz, by_voxels))) < 1e-6


@pytest.mark.parametrize("on_grid", [True, False])
def test_a_part_is_a_part_of_the_whole(on_grid):
    xyz, grid = make_leaves()
    xyz[::50] = np.nan
    xyz[7::60] = 0.0
    chosen = grid if on_grid else None
    asked = np.flatnonzero((grid.row > 90) & (grid.column < 33))
    part, full = fit(xyz, chosen, asked=asked), fit(xyz, chosen)
    assert np.array_equal(part.count, full.count[asked])
    assert np.array_equal(part.width, full.width[asked])
    assert np.allclose(part.normals, full.normals[asked], atol=1e-9, equal_nan=True)
    lost = ~np.isfinite(xyz).all(axis=1) | ~xyz.any(axis=1)
    assert (full.width[lost] == 0).all()
    assert (full.count[lost] == 0).all()
    assert np.isnan(full.normals[lost]).all()


def test_memory_per_grid_cell():
    warm_up("cells")
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:900, :900])
    xyz = np.stack([np.full(row.size, 2.0), (column - 450) * 1e-3, (row - 450) * 1e-3], axis=1)
    grid = as_cells(SimpleNamespace(rows=900, columns=900, row=row, column=column))
    tracemalloc.start()
    try:
        planes = fit_balls(as_points(xyz), ORIGIN, grid, None, RADIUS, QUIET)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert planes.method == "scan grid"
    assert peak / row.size <= 60.0
