"""Cells of a leaf: means of valid points, grey for the rest, nothing where nothing is."""

from __future__ import annotations

import numpy as np
import pytest

from app.render.palettes import MISSING, colour_table
from widgets.common.wrinkles.rasters import PALETTE, find_spacing, paint, rasterise


def every(places):
    return np.ones(len(places), bool)


@pytest.fixture
def leaf():
    """A lattice of 40 × 30 points a millimetre apart, tilted up from left to right."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(40.0), np.arange(30.0)))
    return x, y, x - 19.5


def test_a_cell_is_about_one_point(leaf) -> None:
    x, y, _ = leaf
    assert find_spacing(x, y) == pytest.approx(1.0, abs=0.1)


def test_values_lie_where_the_points_lie(leaf) -> None:
    x, y, values = leaf
    found = rasterise(x, y, values, every(x), every(x), 1.0)
    n = len(found.values)
    for at in (0, 517, len(x) - 1):
        row = int((y[at] - found.low) / found.side * n)
        column = int((x[at] - found.left) / found.side * n)
        assert found.values[row, column] == pytest.approx(values[at], abs=1.01)
    known = np.isfinite(found.values)
    assert known.any(axis=0).sum() == pytest.approx(40, abs=2)
    assert known.any(axis=1).sum() == pytest.approx(30, abs=2)
    assert not found.grey.any()


def test_points_that_are_not_valid_are_grey_and_never_averaged(leaf) -> None:
    x, y, values = leaf
    valid = x < 20.0
    found = rasterise(x, y, np.where(valid, values, 1e9), valid, every(x), 1.0)
    assert np.nanmax(found.values) < 1.0
    assert not (found.grey & np.isfinite(found.values)).any()
    painted = paint(found, 20.0, MISSING["light"])
    assert (painted[found.grey] == (*MISSING["light"], 255)).all()
    empty = np.isnan(found.values) & ~found.grey
    assert empty.any()
    assert (painted[empty, 3] == 0).all()


def test_a_leaf_without_a_valid_point_is_grey_all_over(leaf) -> None:
    x, y, values = leaf
    found = rasterise(x, y, values, ~every(x), every(x), 1.0)
    assert not np.isfinite(found.values).any()
    assert found.grey.sum() > 1000


def test_zero_is_green_and_the_ends_are_those_of_the_palette(leaf) -> None:
    x, y, values = leaf
    found = rasterise(x, y, values, every(x), every(x), 1.0)
    painted, table = paint(found, 5.0, MISSING["light"]), colour_table(PALETTE)
    low, high = np.nanargmin(found.values), np.nanargmax(found.values)
    assert (painted.reshape(-1, 4)[low] == table[0]).all()
    assert (painted.reshape(-1, 4)[high] == table[255]).all()
    middle = painted.reshape(-1, 4)[np.nanargmin(np.abs(found.values))].astype(int)
    assert middle[1] > max(middle[0], middle[2])


def test_a_point_far_off_does_not_shrink_the_leaf(leaf) -> None:
    x, y, values = leaf
    far = np.append(x, 5000.0), np.append(y, 5000.0)
    found = rasterise(*far, np.append(values, 0.0), every(far[0]), every(far[0]), 1.0)
    assert found.side < 60.0
    many = np.append(x, np.full(len(x), 5000.0)), np.append(y, np.full(len(x), 5000.0))
    own = np.arange(2 * len(x)) < len(x)
    found = rasterise(*many, np.append(values, values), every(many[0]), own, 1.0)
    assert found.side < 60.0
