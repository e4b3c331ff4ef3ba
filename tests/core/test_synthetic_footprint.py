"""Synthetic footprints against a tree of directions, brute force and beams of simulated scans."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.core.errors import Cancelled, WrongUse
from app.core.progress import LiveProgress
from app.core.synthetic_footprint import find_lines, smooth, smooth_by_tree
from app.model.scan import Scan
from app.simulate.scenes import leaf_row_scan

SCANNER = np.array([1.0, -2.0, 0.5])


def sphere(rows: int, columns: int, step: float, start: float, seam: bool = False) -> tuple:
    """Points at random ranges on an exact grid of directions; a fifth of them missing."""
    random = np.random.default_rng(5)
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    kept = random.uniform(size=row.size) > 0.2
    row, column = row[kept], column[kept]
    width = 2 * np.pi / columns if seam else step
    height, turn = start - step * row, 0.3 - width * column
    beams = np.stack(
        [np.cos(height) * np.cos(turn), np.cos(height) * np.sin(turn), np.sin(height)], axis=1
    )
    away = random.uniform(1.0, 6.0, len(row))
    grid = SimpleNamespace(rows=rows, columns=columns, row=row, column=column)
    return beams, away, SCANNER + beams * away[:, None], grid


def brute(values: np.ndarray, beams: np.ndarray, half: np.ndarray, counted: np.ndarray) -> tuple:
    """Means over all pairs of beams, one by one."""
    near = np.arccos(np.clip(beams @ beams.T, -1, 1)) <= half[:, None]
    near &= counted
    count = near.sum(axis=1)
    with np.errstate(invalid="ignore"):
        return (near @ np.where(counted, values, 0.0)) / count, count


@pytest.mark.parametrize("case", [(40, 50, 0.004, 0.1, False), (30, 90, 0.02, 1.3, True)])
@pytest.mark.parametrize("diameter", [0.0311, 0.217])
def test_grid_tree_and_brute_force_agree(case: tuple, diameter: float) -> None:
    beams, away, xyz, grid = sphere(*case)
    random = np.random.default_rng(1)
    values = random.uniform(0.1, 1.0, (2, len(xyz)))
    values[0, ::17] = np.nan
    left_out = random.uniform(size=len(xyz)) < 0.1
    counted = np.isfinite(values).all(axis=0) & ~left_out
    half = np.arctan(diameter / (2 * away))
    wanted, count = brute(values[1], beams, half, counted)
    found = smooth(values, xyz, SCANNER, grid, diameter, left_out=left_out)
    tree = smooth(values, xyz, SCANNER, None, diameter, left_out=left_out)
    np.testing.assert_array_equal(tree.count, count)
    np.testing.assert_allclose(tree.values[1], wanted, rtol=1e-12)
    np.testing.assert_array_equal(found.count, count)
    np.testing.assert_allclose(found.values[1], wanted, rtol=1e-9)
    assert np.isnan(found.values[0][count == 0]).all()


def test_few_points_get_what_all_get() -> None:
    _, _, xyz, grid = sphere(40, 50, 0.004, 0.1)
    values = np.random.default_rng(2).uniform(0.1, 1.0, (1, len(xyz)))
    some = np.array([700, 3, 41])
    for cells in (grid, None):
        all_of_them = smooth(values, xyz, SCANNER, cells, 0.05)
        few = smooth(values, xyz, SCANNER, cells, 0.05, some)
        np.testing.assert_array_equal(few.count, all_of_them.count[some])
        np.testing.assert_allclose(few.values, all_of_them.values[:, some], rtol=1e-13)


def test_a_simulated_scan_differs_from_the_tree_at_the_rim_only() -> None:
    scan: Scan = leaf_row_scan(step_deg=0.1, noise_m=0.0007, seed=3)
    scanner = scan.scanner("the test")
    value = scan.channel_values(scan.channels[0].name)[None]
    grid = smooth(value, scan.xyz, scanner, scan.grid, 0.037)
    away = scan.xyz - scanner
    size = np.linalg.norm(away, axis=1)
    tree = smooth_by_tree(
        value, away / size[:, None], np.isfinite(value[0]), np.arange(len(size)),
        np.arctan(0.037 / (2 * size)),
    )  # fmt: skip
    assert np.mean(grid.count == tree.count) > 0.9
    assert np.abs(grid.count - tree.count).max() <= 4
    assert np.median(np.abs(grid.values - tree.values)) < 1e-12


def test_points_without_place_and_bad_diameters() -> None:
    _, _, xyz, grid = sphere(20, 20, 0.004, 0.1)
    xyz[5] = np.nan
    values = np.ones((1, len(xyz)))
    for cells in (grid, None):
        found = smooth(values, xyz, SCANNER, cells, 0.05)
        assert found.count[5] == 0
        assert np.isnan(found.values[0, 5])
        np.testing.assert_allclose(np.delete(found.values[0], 5), 1.0, rtol=1e-12)
    for wrong in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(WrongUse, match="diameter"):
            smooth(values, xyz, SCANNER, None, wrong)


def test_it_can_be_cancelled() -> None:
    _, _, xyz, grid = sphere(20, 20, 0.004, 0.1)
    progress = LiveProgress(lambda *_: None, cancelled=lambda: True)
    for cells in (grid, None):
        with pytest.raises(Cancelled):
            smooth(np.ones((1, len(xyz))), xyz, SCANNER, cells, 0.05, progress=progress)


def test_a_grid_that_does_not_follow_the_beams_is_not_used() -> None:
    _, _, xyz, grid = sphere(40, 50, 0.004, 0.1)
    random = np.random.default_rng(3)
    shuffled = SimpleNamespace(
        rows=40,
        columns=50,
        row=random.permutation(grid.row),
        column=random.permutation(grid.column),
    )
    assert find_lines(xyz, SCANNER, shuffled) is None
    values = random.uniform(size=(1, len(xyz)))
    found, tree = (smooth(values, xyz, SCANNER, cells, 0.05) for cells in (shuffled, None))
    np.testing.assert_array_equal(found.count, tree.count)
