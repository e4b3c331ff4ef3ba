from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.screen import pick, visible_mask

SIZE = (40, 30)


def scatter(seed: int, n: int = 300) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    px = rng.uniform((0, 0), SIZE, (n, 2)).astype(np.float32)
    return px, rng.uniform(1, 2, n).astype(np.float32), rng.random(n) > 0.2


def covered(px: np.ndarray, splat: int) -> np.ndarray:
    """Does the square of point j cover the pixel of point i? (n, n)."""
    corner = np.floor(px.astype(np.float64) - (splat - 1) / 2)
    step = np.floor(px)[:, None, :] - corner[None]
    return ((step >= 0) & (step < splat)).all(axis=2)


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(1, 6), st.floats(0, 0.5))
def test_against_all_pairs(seed: int, splat: int, tolerance: float) -> None:
    px, depth, inside = scatter(seed)
    over = covered(px, splat) & inside[None]
    front = np.where(over, depth[None].astype(np.float64), np.inf).min(axis=1)
    expected = inside & (depth <= front + tolerance)
    got = visible_mask(px, depth, inside, SIZE, splat, tolerance)
    np.testing.assert_array_equal(got, expected)


@settings(deadline=None)
@given(st.integers(0, 1000))
def test_the_order_of_the_points_does_not_matter(seed: int) -> None:
    px, depth, inside = scatter(seed)
    order = np.random.default_rng(seed + 1).permutation(len(px))
    got = visible_mask(px[order], depth[order], inside[order], SIZE, 3, 0.01)
    np.testing.assert_array_equal(got, visible_mask(px, depth, inside, SIZE, 3, 0.01)[order])


@settings(deadline=None)
@given(st.integers(0, 1000), st.floats(0, 1), st.floats(0, 1))
def test_more_tolerance_never_hides_a_point(seed: int, one: float, two: float) -> None:
    px, depth, inside = scatter(seed)
    strict = visible_mask(px, depth, inside, SIZE, 2, min(one, two))
    loose = visible_mask(px, depth, inside, SIZE, 2, max(one, two))
    assert not (strict & ~loose).any()


def test_what_does_not_take_part_hides_nothing() -> None:
    px = np.full((2, 2), 5.5, np.float32)
    depth = np.array([1.0, 2.0], np.float32)
    assert visible_mask(px, depth, np.array([False, True]), SIZE).tolist() == [False, True]
    assert visible_mask(px, depth, np.array([True, True]), SIZE).tolist() == [True, False]


def test_pixels_that_are_not_on_the_screen_do_no_harm() -> None:
    px = np.array([[np.nan, 1], [np.inf, 1], [-1e30, 1], [1e30, -1e30], [3, 3]], np.float32)
    got = visible_mask(px, np.ones(5, np.float32), np.ones(5, bool), SIZE, 64)
    assert got.tolist() == [False, False, False, False, True]


@pytest.mark.parametrize(("splat", "tolerance"), [(0, 0.1), (65, 0.1), (2, -1.0), (2, np.nan)])
def test_senseless_settings_are_refused(splat: int, tolerance: float) -> None:
    with pytest.raises(BadInput):
        visible_mask(*scatter(0), SIZE, splat, tolerance)


ALL = np.ones(3, bool)


def test_pick_prefers_the_point_under_the_cursor() -> None:
    px = np.array([[10, 10], [13, 10], [30, 10]], np.float32)
    depth = np.array([5.0, 1.0, 1.0], np.float32)
    assert pick(px, depth, ALL, (10.4, 10.0), 8.0) == 0
    assert pick(px, depth, ALL, (12.6, 10.0), 8.0) == 1


def test_pick_takes_the_front_of_points_that_cover_each_other() -> None:
    px = np.array([[10, 10], [10.6, 10.2], [10.1, 10]], np.float32)
    depth = np.array([2.0, 1.0, 3.0], np.float32)
    assert pick(px, depth, ALL, (10.0, 10.0), 8.0) == 1
    assert pick(px, depth, np.array([True, False, True]), (10.0, 10.0), 8.0) == 0


def test_pick_at_equal_places_and_depths_takes_the_first_row() -> None:
    px = np.full((3, 2), 10.0, np.float32)
    assert pick(px, np.ones(3, np.float32), ALL, (10.0, 10.0), 8.0) == 0


def test_pick_finds_nothing_beyond_the_radius_or_without_pixels() -> None:
    px = np.array([[10, 10], [np.nan, np.nan], [30, 10]], np.float32)
    depth = np.array([1.0, np.nan, 1.0], np.float32)
    assert pick(px, depth, ALL, (20.0, 10.0), 9.0) == -1
    assert pick(px, depth, ALL, (19.5, 10.0), 9.6) == 0
    assert pick(px[:0], depth[:0], ALL[:0], (20.0, 10.0), 9.0) == -1


@settings(deadline=None)
@given(st.integers(0, 1000), st.floats(-5, 45), st.floats(-5, 35), st.floats(1, 12))
def test_pick_is_the_nearest_point_that_is_seen(
    seed: int, x: float, y: float, radius: float
) -> None:
    px, depth, mask = scatter(seed, 120)
    got = pick(px, depth, mask, (x, y), radius, splat=1)
    distance = np.hypot(px[:, 0] - x, px[:, 1] - y)
    if got < 0:
        # Positions are single precision: on the very rim either answer is right.
        assert not (mask & (distance <= radius * (1 - 1e-6))).any()
        return
    assert mask[got]
    assert distance[got] <= radius
    # A closer one can only have been passed over because something nearer covers its pixel.
    for i in np.flatnonzero(mask & (distance < distance[got])):
        same = mask & (np.abs(px - px[i]) < 1.001).all(axis=1)
        assert depth[same].min() < depth[i]
