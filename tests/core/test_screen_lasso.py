from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path

from app.core.errors import BadInput
from app.core.screen import lasso_mask, rasterise_polygon

SIZE = (90, 60)
corner = st.tuples(st.floats(-30, 120), st.floats(-30, 90))


def centres() -> np.ndarray:
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    return np.column_stack([x.ravel(), y.ravel()])


def distance_to_border(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    best = np.full(len(points), np.inf)
    for start, stop in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        along = stop - start
        length = along @ along
        t = np.clip((points - start) @ along / length, 0, 1) if length else np.zeros(len(points))
        best = np.minimum(best, np.linalg.norm(points - start - t[:, None] * along, axis=1))
    return best


def winding_number(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Sum of the angles that the edges subtend: another way to the same number."""
    a = polygon[None] - points[:, None]
    b = np.roll(a, -1, axis=1)
    cross = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    angle = np.arctan2(cross, (a * b).sum(axis=2))
    return np.rint(angle.sum(axis=1) / (2 * np.pi))


@settings(deadline=None)
@given(st.integers(3, 40), st.integers(0, 10_000))
def test_star_shapes_agree_with_matplotlib(k: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, k))
    radius = rng.uniform(5, 60, k)
    polygon = np.column_stack([45 + radius * np.cos(angle), 30 + radius * np.sin(angle)])
    points = rng.uniform(-10, 100, (400, 2))
    away = distance_to_border(points, polygon) > 0.75
    on_screen = ((points >= 0) & (points < SIZE)).all(axis=1)
    # Matplotlib's own rule is even-odd; without self-crossing both rules agree.
    gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    if gaps.max() < np.pi:
        expected = Path(polygon).contains_points(points) & on_screen
        got = lasso_mask(points.astype(np.float32), polygon, SIZE)
        np.testing.assert_array_equal(got[away], expected[away])


@settings(max_examples=60, deadline=None)
@given(st.lists(corner, min_size=3, max_size=12))
def test_freehand_lines_that_cross_themselves_follow_the_winding_number(corners: list) -> None:
    polygon = np.array(corners)
    points = centres()
    away = distance_to_border(points, polygon) > 1e-6
    expected = winding_number(points, polygon) != 0
    np.testing.assert_array_equal(rasterise_polygon(polygon, SIZE).ravel()[away], expected[away])


@settings(deadline=None)
@given(st.lists(corner, min_size=3, max_size=12), st.integers(0, 11))
def test_start_and_direction_do_not_matter(corners: list, shift: int) -> None:
    polygon = np.round(np.array(corners), 1)
    picture = rasterise_polygon(polygon, SIZE)
    points = centres()
    away = (distance_to_border(points, polygon) > 1e-6).reshape(picture.shape)
    for same in (np.roll(polygon, shift, axis=0), polygon[::-1]):
        np.testing.assert_array_equal(rasterise_polygon(same, SIZE)[away], picture[away])


def test_a_loop_drawn_twice_keeps_its_inside() -> None:
    square = np.array([[10, 10], [50, 10], [50, 40], [10, 40]], float)
    once, twice = rasterise_polygon(square, SIZE), rasterise_polygon(np.tile(square, (2, 1)), SIZE)
    np.testing.assert_array_equal(once, twice)
    assert once.sum() == 40 * 30
    assert once[10:40, 10:50].all()


def test_neighbouring_lassos_share_no_pixel_and_leave_none_out() -> None:
    left = rasterise_polygon(np.array([[0, 0], [33.5, 0], [50.2, 60], [0, 60]]), SIZE)
    right = rasterise_polygon(np.array([[90, 0], [33.5, 0], [50.2, 60], [90, 60]]), SIZE)
    assert not (left & right).any()
    assert (left | right).all()


def test_points_off_the_screen_and_without_pixels_are_never_inside() -> None:
    everything = np.array([[-1e6, -1e6], [1e6, -1e6], [1e6, 1e6], [-1e6, 1e6]])
    px = [[0, 0], [89.99, 59.99], [90, 10], [10, 60], [-0.01, 5], [np.nan, 5], [np.inf, 5]]
    got = lasso_mask(np.array(px, np.float32), everything, SIZE)
    assert got.tolist() == [True, True, False, False, False, False, False]


@pytest.mark.parametrize(
    "polygon", [np.zeros((2, 2)), np.zeros((5, 3)), np.array([[0, 0], [1, 1], [np.nan, 2]])]
)
def test_what_is_no_polygon_is_refused(polygon: np.ndarray) -> None:
    with pytest.raises(BadInput, match="lasso"):
        rasterise_polygon(polygon, SIZE)
