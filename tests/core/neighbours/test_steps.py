"""Beam steps are measured from the points: anisotropic, at poles, over the seam."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.neighbours.steps import LINES, UnusableGrid, measure_steps


def make_sphere(rows, columns, low, high, turn, radius=2.0):
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    elevation = low + (high - low) * row / (rows - 1)
    azimuth = turn * column / columns
    xyz = radius * np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    return xyz, SimpleNamespace(rows=rows, columns=columns, row=row, column=column), elevation


def test_anisotropic_steps_and_pole():
    xyz, grid, elevation = make_sphere(181, 300, -0.5, np.pi / 2, np.pi)
    steps = measure_steps(xyz, np.zeros(3), grid)
    assert np.allclose(steps.down, (np.pi / 2 + 0.5) / 180, rtol=1e-6)
    expected = np.cos(elevation.reshape(181, 300)[:, 0]) * np.pi / 300
    assert np.allclose(steps.across, expected, rtol=0.02, atol=2e-4)
    assert not steps.seam


def test_full_turn_has_a_seam_and_rotation_does_not_matter():
    xyz, grid, _ = make_sphere(60, 360, -0.6, 0.6, 2 * np.pi)
    turned = xyz @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].T
    for points in (xyz, turned + 1e6):
        centre = np.zeros(3) if points is xyz else np.full(3, 1e6)
        assert measure_steps(points, centre, grid).seam


def test_noise_is_the_range_noise():
    xyz, grid, _ = make_sphere(200, 200, -0.3, 0.3, 0.6)
    noise = np.random.default_rng(2).normal(0, 0.0007, len(xyz))
    xyz = xyz * (1 + noise / 2.0)[:, None]
    assert measure_steps(xyz, np.zeros(3), grid).noise == pytest.approx(0.0007, rel=0.1)


def test_grid_of_a_wrong_position_is_not_used():
    xyz, grid, _ = make_sphere(60, 60, -0.3, 0.3, 0.6)
    shuffled = np.random.default_rng(3).permutation(len(xyz))
    with pytest.raises(UnusableGrid, match="do not follow"):
        measure_steps(xyz[shuffled], np.zeros(3), grid)


def test_damaged_grids_are_refused():
    xyz, grid, _ = make_sphere(20, 20, -0.3, 0.3, 0.6)
    grid.row = grid.row.copy()
    grid.row[7] = 20
    with pytest.raises(BadInput, match="outside the grid"):
        measure_steps(xyz, np.zeros(3), grid)
    with pytest.raises(BadInput, match="places 400 points"):
        measure_steps(xyz[:10], np.zeros(3), grid)
    grid.rows, grid.columns = 10**6, 10**6
    with pytest.raises(UnusableGrid, match="empty"):
        measure_steps(xyz, np.zeros(3), grid)


def test_steps_are_medians_over_the_filled_cells():
    """Holes of up to four cells are bridged, longer ones and lost points are not."""
    xyz, grid, _ = make_sphere(60, 60, -0.3, 0.3, 0.6)
    rng = np.random.default_rng(4)
    kept = (rng.random(len(xyz)) > 0.4) & (grid.column % 20 > 7)
    xyz, grid.row, grid.column = xyz[kept], grid.row[kept], grid.column[kept]
    xyz = xyz * (1 + rng.uniform(-0.02, 0.02, (len(xyz), 3)) * 0.05)
    xyz[rng.random(len(xyz)) < 0.05] = np.nan
    steps = measure_steps(xyz, np.zeros(3), grid)
    for r in np.unique(np.linspace(0, 59, LINES).astype(int))[::5]:
        line = np.flatnonzero(grid.row == r)
        a, b, gap = xyz[line[:-1]], xyz[line[1:]], np.diff(grid.column[line])
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)) / gap
        expected = np.median(angle[(gap <= 4) & np.isfinite(angle)])
        assert steps.across[r] == pytest.approx(expected, rel=1e-9)
