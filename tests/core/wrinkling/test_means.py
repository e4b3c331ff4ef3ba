"""Means over the footprint, the noise behind them, and the shape of a distribution."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.neighbours.steps import Cells
from app.core.synthetic_footprint import find_lines, smooth
from app.core.wrinkles import distribution
from app.core.wrinkling.leaf import Choices
from app.core.wrinkling.means import average_leaf, cut_grid, measure_noise, noise_of_means
from app.core.wrinkling.shape import name_shape

ROWS, COLUMNS, STEP = 60, 80, 3e-4
ROW, COLUMN = (a.ravel().astype(np.int32) for a in np.mgrid[:ROWS, :COLUMNS])
AZIMUTH, ELEVATION = 0.2 + STEP * COLUMN, 0.1 - STEP * ROW
XYZ = 3.0 * np.stack(
    [
        np.cos(ELEVATION) * np.cos(AZIMUTH),
        np.cos(ELEVATION) * np.sin(AZIMUTH),
        np.sin(ELEVATION),
    ],
    axis=1,
)
SCANNER = np.zeros(3)
GRID = Cells(ROWS, COLUMNS, ROW, COLUMN)
DIAMETER = 0.005


def make_values(noise, seed=1):
    slope = 0.3 + 0.1 * np.sin(COLUMN / 12.0) + 0.002 * ROW
    return slope * (1 + noise * np.random.default_rng(seed).standard_normal(len(ROW)))


def test_a_leaf_is_averaged_as_the_whole_scan_would_be():
    lines = find_lines(XYZ, SCANNER, GRID)
    leaf = np.flatnonzero((ROW > 10) & (ROW < 50) & (COLUMN > 20) & (COLUMN < 70))
    full = np.random.default_rng(2).random(len(leaf)) > 0.2
    values = make_values(0.03)
    cells, part = cut_grid(GRID, lines, leaf)
    found = average_leaf(values[leaf], XYZ[leaf], SCANNER, DIAMETER, full, cells, part)
    left_out = np.ones(len(ROW), bool)
    left_out[leaf[full]] = False
    expected = smooth(values[None], XYZ, SCANNER, GRID, DIAMETER, leaf, left_out)
    assert np.allclose(found.values, expected.values[0], equal_nan=True)
    assert (found.count == expected.count).all()


def test_without_a_grid_the_same_comes_out():
    lines = find_lines(XYZ, SCANNER, GRID)
    values = make_values(0.03)
    cells, part = cut_grid(GRID, lines, np.arange(len(ROW)))
    by_grid = average_leaf(values, XYZ, SCANNER, DIAMETER, None, cells, part)
    by_tree = average_leaf(values, XYZ, SCANNER, DIAMETER)
    assert np.median(np.abs(by_grid.values - by_tree.values)) < 1e-3


@pytest.mark.parametrize("cells", [GRID, None], ids=["grid", "no grid"])
def test_noise_is_measured_whatever_the_slopes(cells):
    found = measure_noise(make_values(0.03), XYZ, SCANNER, "linear", None, cells)
    assert found == pytest.approx(0.03, rel=0.1)
    dn = 600 * np.log10(make_values(0.0)) + 4 * np.random.default_rng(3).standard_normal(len(ROW))
    assert measure_noise(dn, XYZ, SCANNER, "log", None, cells) == pytest.approx(4.0, rel=0.15)


def test_noise_of_too_few_points_is_unknown():
    assert np.isnan(measure_noise(np.ones(5), XYZ[:5], SCANNER, "linear"))


def test_noise_of_means():
    count = np.array([1, 4, 0])
    assert np.allclose(noise_of_means(0.02, np.full(3, 0.5), count, "linear"), [0.01, 0.005, 0.01])
    assert np.allclose(noise_of_means(6.0, np.full(3, 900.0), count, "log"), [6.0, 3.0, 6.0])
    with pytest.raises(WrongUse):
        noise_of_means(-1.0, np.ones(3), count, "log")


def test_words_for_shapes():
    random = np.random.default_rng(4)
    one = random.normal(0, 0.05, 5000)
    assert name_shape(distribution(one)) == "unimodal"
    assert name_shape(distribution(random.gamma(1.5, 0.05, 5000))) == "skewed"
    two = np.concatenate([one - 0.2, one + 0.2])
    assert name_shape(distribution(two)) == "several modes"
    assert name_shape(distribution(one[:20])) == "too few points"


@pytest.mark.parametrize("noise", [-1.0, np.nan, np.inf])
def test_a_noise_that_is_none_is_refused_before_any_leaf(noise):
    with pytest.raises(WrongUse, match="noise"):
        Choices(noise=noise)
