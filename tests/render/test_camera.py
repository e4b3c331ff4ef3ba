from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.render.camera import (
    DIRECTIONS,
    Camera,
    centre_on,
    fit_points,
    look_at_points,
    look_from,
    make_orthographic,
    pan,
    turn,
    zoom,
)

START = Camera((3.0, -4.0, 2.0), (0.5, 0.2, 0.1), (0.0, 0.0, 1.0))
SHARE = st.floats(-0.5, 0.5)


def place_of(camera: Camera, point: np.ndarray) -> tuple[float, float]:
    """Shares of the view's height right and up of the middle; the textbook pinhole."""
    right, up, forward = camera.axes()
    arm = point - np.array(camera.position)
    if camera.parallel_scale is not None:
        half = camera.parallel_scale
    else:
        half = (arm @ forward) * np.tan(np.radians(camera.view_angle) / 2)
    return arm @ right / half / 2, arm @ up / half / 2


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_turning_keeps_distance_and_centre(right: float, up: float) -> None:
    turned = turn(START, right, up)
    assert turned.distance == pytest.approx(START.distance)
    assert turned.focal_point == START.focal_point
    x, y, z = turned.axes()
    assert np.allclose(np.array([x, y, z]) @ np.array([x, y, z]).T, np.eye(3), atol=1e-9)


def test_turning_right_moves_what_is_in_front_to_the_right() -> None:
    _, _, forward = START.axes()
    near = np.array(START.focal_point) - 0.3 * forward
    right, _ = place_of(turn(START, 0.1, 0.0), near)
    _, up = place_of(turn(START, 0.0, 0.1), near)
    assert right > 0.001
    assert up > 0.001


@pytest.mark.parametrize("orthographic", [False, True])
@given(right=SHARE, up=SHARE, factor=st.floats(0.2, 5))
def test_zoom_keeps_what_is_under_the_cursor(
    orthographic: bool, right: float, up: float, factor: float
) -> None:
    camera = make_orthographic(START, orthographic)
    x, y, _ = camera.axes()
    point = camera.focal_point + 2 * camera.half_height * (right * x + up * y)
    assert place_of(zoom(camera, factor, right, up), point) == pytest.approx((right, up))
    assert zoom(camera, factor).half_height == pytest.approx(camera.half_height / factor)


@given(SHARE, SHARE)
def test_panning_moves_the_centre_with_the_hand(right: float, up: float) -> None:
    moved = place_of(pan(START, right, up), np.array(START.focal_point))
    assert moved == pytest.approx((right, up), abs=1e-9)


def test_orthographic_and_back_keeps_the_size() -> None:
    there = make_orthographic(START, True)
    back = make_orthographic(there, False)
    assert there.half_height == pytest.approx(START.half_height)
    assert np.allclose(back.position, START.position)


def test_a_new_centre_keeps_the_direction() -> None:
    moved = centre_on(START, np.array([1.0, 1.0, 1.0]))
    assert moved.focal_point == (1.0, 1.0, 1.0)
    assert np.allclose(moved.axes(), START.axes())


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("name", DIRECTIONS)
def test_standard_views_show_every_point_and_waste_little(name: str, orthographic: bool) -> None:
    points = np.random.default_rng(2).uniform((-1, 4, 0), (2, 5, 3), (500, 3))
    camera = look_at_points(points, name, 1.5, orthographic)
    places = np.array([place_of(camera, point) for point in points])
    reach = np.abs(places).max(axis=0) * 2 / (1.5, 1.0)
    assert reach.max() < 1.0
    assert reach.max() > 0.75


def test_unknown_view_is_refused() -> None:
    with pytest.raises(WrongUse, match="top"):
        look_at_points(np.zeros((1, 3)), "sideways")


def test_one_point_can_be_looked_at() -> None:
    camera = fit_points(START, np.ones((1, 3)), 1.5)
    assert camera.focal_point == pytest.approx((1, 1, 1))
    assert camera.distance > 0.1


def test_the_scanner_sees_its_scan_from_where_it_stands() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform((5, -1, -1), (6, 2, 1), (400, 3))
    camera = look_from(np.zeros(3), points, 1.5)
    assert camera.position == (0.0, 0.0, 0.0)
    places = np.array([place_of(camera, point) for point in points])
    reach = np.abs(places).max(axis=0) * 2 / (1.5, 1.0)
    assert 0.85 < reach.max() < 1.0


def test_a_scanner_amid_its_scan_steps_back() -> None:
    points = np.random.default_rng(4).normal((0.5, 0, 0), 3, (400, 3))
    camera = look_from(np.zeros(3), points, 1.5)
    places = np.array([place_of(camera, point) for point in points])
    assert np.abs(places).max() < 0.75
    assert camera.view_angle < 60
