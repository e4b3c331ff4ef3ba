"""Ghost scores and corrections on a scene whose truth is known by construction."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.ghosts import THRESHOLD, correct_ghosts, ghost_score
from app.core.incidence import incidence_angle, local_planes

ORIGIN = np.zeros(3)
STEP = 3e-4


def make_scene(tilt=0.6, noise=0.0005, seed=0):
    """A round leaf at 2 m before a wall at 2.5 m; beams on its border give ranges between."""
    row, column = (a.ravel() for a in np.mgrid[:140, :140])
    el, az = (row - 70) * STEP, (column - 70) * STEP
    beams = np.stack([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)], axis=1)
    wall = 2.5 / beams[:, 0]
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    leaf = 2.0 * np.cos(tilt) / (beams @ normal)
    from_centre = np.hypot(row - 70, column - 70)
    share = np.clip((42.0 - from_centre) / 3.0 + 0.5, 0.0, 1.0)
    clean = np.where(share > 0.5, leaf, wall)
    ghost = (share > 0.02) & (share < 0.98)
    rng = np.random.default_rng(seed)
    mixed = share * leaf + (1 - share) * wall + rng.normal(0, noise, len(row))
    grid = SimpleNamespace(rows=140, columns=140, row=row, column=column)
    return beams * mixed[:, None], grid, ghost, clean, share


def f1(score, truth):
    called = score >= THRESHOLD
    return 2 * (called & truth).sum() / (called.sum() + truth.sum())


@pytest.mark.parametrize(("on_grid", "least"), [(True, 0.9), (False, 0.8)])
def test_border_points_are_found(on_grid, least):
    xyz, grid, ghost, _, share = make_scene()
    score = ghost_score(xyz, ORIGIN, None, grid if on_grid else None)
    assert f1(score, ghost) > least
    assert ((score >= 0) & (score <= 1)).all()
    if on_grid:
        assert (score[share == 1.0] < THRESHOLD).mean() > 0.995


def test_steep_leaf_without_border_has_no_ghosts():
    xyz, grid, _, _, _ = make_scene(tilt=np.deg2rad(72))
    inside = np.hypot(grid.row - 70, grid.column - 70) < 34
    planes = local_planes(xyz, ORIGIN, grid=grid)
    angle = incidence_angle(xyz, planes.normals, ORIGIN)
    score = ghost_score(xyz, ORIGIN, None, grid, incidence=angle)
    assert (score[inside] < THRESHOLD).all()


@pytest.mark.parametrize("on_grid", [True, False])
def test_subset_equals_full_and_missing_is_nan(on_grid):
    xyz, grid, ghost, _, _ = make_scene()
    xyz[3] = np.nan
    xyz[4] = 0.0
    chosen = grid if on_grid else None
    intensity = np.where(ghost, 0.2, 1.0)
    full = ghost_score(xyz, ORIGIN, None, chosen, intensity=intensity)
    asked = np.array([9800, 3, 4, 5000, 9800])
    part = ghost_score(xyz, ORIGIN, asked, chosen, intensity=intensity)
    assert np.allclose(part, full[asked], equal_nan=True)
    assert np.isnan(part).tolist() == [False, True, True, False, False]


def test_grazing_and_dark_points_are_more_doubtful():
    xyz, grid, ghost, _, _ = make_scene()
    plain = ghost_score(xyz, ORIGIN, None, grid)
    dark = ghost_score(xyz, ORIGIN, None, grid, intensity=np.where(ghost, 0.1, 1.0))
    grazing = ghost_score(xyz, ORIGIN, None, grid, incidence=np.full(len(xyz), 1.5))
    doubtful = ghost & (plain > 0) & (plain < 1)
    assert (dark[doubtful] >= plain[doubtful]).all()
    assert (dark[doubtful] > plain[doubtful]).mean() > 0.5
    assert (grazing[doubtful] > plain[doubtful]).all()


def test_lonely_point_is_a_ghost():
    row, column = (a.ravel() for a in np.mgrid[:30, :30])
    xyz = np.stack([np.full(900, 2.0), (column - 15) * 6e-4, (row - 15) * 6e-4], axis=1)
    lonely = 15 * 30 + 15
    near = np.hypot(row - 15, column - 15)
    xyz[(near < 9) & (near > 0)] = np.nan
    grid = SimpleNamespace(rows=30, columns=30, row=row, column=column)
    score = ghost_score(xyz, ORIGIN, None, grid)
    assert score[lonely] == 1.0
    assert np.nanmax(np.delete(score, lonely)) < THRESHOLD


@pytest.mark.parametrize("on_grid", [True, False])
def test_correction_puts_ghosts_on_the_surface_that_owns_them(on_grid):
    xyz, grid, ghost, clean, share = make_scene()
    numbers = np.flatnonzero(ghost)
    moved, corrected = correct_ghosts(xyz, ORIGIN, numbers, grid if on_grid else None)
    assert corrected.mean() > 0.9
    error = np.abs(np.linalg.norm(moved, axis=1) - clean[numbers])
    sure = corrected & (np.abs(share[numbers] - 0.5) > 0.1)
    assert np.mean(error[sure] < 0.005) > 0.95
    before, after = xyz[numbers], moved
    assert np.linalg.norm(np.cross(before, after), axis=1).max() < 1e-9


def test_ghost_without_a_surface_stays():
    xyz, grid, _, _, _ = make_scene()
    far = np.hypot(grid.row - 70, grid.column - 70)
    xyz[(far < 20) & (far > 0)] = np.nan
    lonely = np.flatnonzero(far == 0)
    nothing = np.flatnonzero(np.isnan(xyz[:, 0]))[:1]
    for chosen in (grid, None):
        moved, corrected = correct_ghosts(xyz, ORIGIN, np.append(lonely, nothing), chosen)
        assert not corrected.any()
        assert np.array_equal(moved[0], xyz[lonely[0]])
    assert correct_ghosts(xyz, ORIGIN, np.empty(0, np.int64), grid)[0].shape == (0, 3)


@pytest.mark.data
@pytest.mark.parametrize(("name", "least"), [("phase_shift", 0.95), ("pulsed", 0.94)])
def test_scenes_of_another_simulator(shared_data, name, least):
    folder = shared_data / "truth_scenes"
    truth = np.load(folder / f"{name}_truth.npz")
    table = np.loadtxt(folder / f"{name}.ptx", skiprows=10)
    xyz = table[table[:, :3].any(axis=1), :3]
    columns, rows = (int(size) for size in truth["shape"])
    grid = SimpleNamespace(rows=rows, columns=columns, row=truth["row"], column=truth["col"])
    score = ghost_score(xyz, ORIGIN, None, grid)
    counted = ~truth["unsure"]
    assert f1(score[counted], truth["ghost"][counted]) > least
    on_one = counted & (truth["hit_fraction"] > 0.9999)
    assert np.mean(score[on_one] >= THRESHOLD) < 0.005
