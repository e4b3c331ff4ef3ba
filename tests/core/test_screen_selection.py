from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.core.screen import View, select_in_lasso

SIZE = (400, 300)
EVERYTHING = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
LEFT_HALF = np.array([[0, 0], [0.5, 0], [0.5, 1], [0, 1]], float)


def perspective(near: float = 0.1, far: float = 100.0) -> np.ndarray:
    """Eye at the origin, looking along −z, 60° high."""
    t, aspect = 1 / np.tan(np.deg2rad(30.0)), SIZE[0] / SIZE[1]
    a, b = -(far + near) / (far - near), -2 * far * near / (far - near)
    return np.array([[t / aspect, 0, 0, 0], [0, t, 0, 0], [0, 0, a, b], [0, 0, -1, 0]])


def orthographic(near: float = 0.1, far: float = 100.0, half: float = 1.2) -> np.ndarray:
    aspect = SIZE[0] / SIZE[1]
    deep = 2 / (far - near)
    return np.array(
        [
            [1 / (half * aspect), 0, 0, 0],
            [0, 1 / half, 0, 0],
            [0, 0, -deep, -(far + near) / (far - near)],
            [0, 0, 0, 1],
        ]
    )


VIEWS = [View.of((0, 0, 0), matrix, SIZE) for matrix in (perspective(), orthographic())]


def two_walls() -> tuple[np.ndarray, int]:
    """A dense small wall at 2 m before a wider one at 3 m."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 300), np.linspace(-0.5, 0.5, 300))
    front = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -2.0)])
    back = front * (1.2, 1.2, 1.5)
    return np.vstack([front, back]), len(front)


@pytest.mark.parametrize("view", VIEWS, ids=["perspective", "orthographic"])
def test_visible_takes_the_front_and_counts_the_hidden(view: View) -> None:
    xyz, n = two_walls()
    seen = select_in_lasso(xyz, None, view, EVERYTHING, "visible")
    through = select_in_lasso(xyz, None, view, EVERYTHING, "through")
    assert len(through.indices) == 2 * n
    assert seen.indices.dtype == np.int64
    assert (np.diff(seen.indices) > 0).all()
    assert np.array_equal(seen.indices[:n], np.arange(n))
    assert seen.hidden == 2 * n - len(seen.indices)
    # In perspective the back wall shrinks to 0.8 of the front one and vanishes behind it.
    inner = np.abs(xyz[n:, :2]).max(axis=1) < 0.49
    assert not np.isin(n + np.flatnonzero(inner), seen.indices).any()
    if view is VIEWS[0]:
        assert seen.hidden == n


def test_deleted_points_are_not_selected_and_hide_nothing() -> None:
    xyz, n = two_walls()
    allowed = np.arange(2 * n) >= n
    seen = select_in_lasso(xyz, allowed, VIEWS[0], EVERYTHING, "visible")
    assert np.array_equal(seen.indices, np.arange(n, 2 * n))
    assert seen.hidden == 0


@pytest.mark.parametrize("view", VIEWS, ids=["perspective", "orthographic"])
@pytest.mark.parametrize("tilt", [0.0, 30.0, 60.0])
def test_a_tilted_surface_does_not_hide_itself(view: View, tilt: float) -> None:
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 400), np.linspace(-0.4, 0.4, 400))
    angle = np.deg2rad(tilt)
    z = -2.0 + y * np.sin(angle)
    xyz = np.column_stack([x.ravel(), (y * np.cos(angle)).ravel(), z.ravel()])
    assert select_in_lasso(xyz, None, view, EVERYTHING, "visible").hidden == 0


def test_half_a_lasso_takes_half_the_points() -> None:
    xyz, _ = two_walls()
    through = select_in_lasso(xyz, None, VIEWS[0], LEFT_HALF, "through")
    assert np.array_equal(through.indices, np.flatnonzero(xyz[:, 0] < 0))


def test_behind_the_camera_and_nan_are_never_selected() -> None:
    xyz = np.array([[0, 0, 2.0], [0, 0, -2.0], [np.nan, 0, -2.0], [0, 0, 0]])
    for view in VIEWS:
        for mode in ("visible", "through"):
            got = select_in_lasso(xyz, None, view, EVERYTHING, mode)
            assert got.indices.tolist() == [1]


def test_the_tolerance_that_was_used_replays_the_selection() -> None:
    xyz = np.random.default_rng(2).uniform((-1, -1, -4), (1, 1, -2), (20_000, 3))
    lasso = np.random.default_rng(3).uniform(0.1, 0.9, (30, 2))
    first = select_in_lasso(xyz, None, VIEWS[0], lasso, "visible")
    again = select_in_lasso(xyz, None, VIEWS[0], lasso, "visible", first.tolerance)
    assert len(first.indices) > 0
    assert first.hidden > 0
    np.testing.assert_array_equal(first.indices, again.indices)
    assert (first.hidden, first.tolerance) == (again.hidden, again.tolerance)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.floats(0, 0.3))
def test_visible_and_hidden_make_up_through(seed: int, tolerance: float) -> None:
    rng = np.random.default_rng(seed)
    xyz = rng.uniform((-1, -1, -4), (1, 1, -1), (2000, 3))
    allowed, lasso = rng.random(2000) > 0.3, rng.uniform(-0.2, 1.2, (8, 2))
    seen = select_in_lasso(xyz, allowed, VIEWS[0], lasso, "visible", tolerance)
    through = select_in_lasso(xyz, allowed, VIEWS[0], lasso, "through")
    assert allowed[through.indices].all()
    assert np.isin(seen.indices, through.indices).all()
    assert len(seen.indices) + seen.hidden == len(through.indices)


def test_large_coordinates_lose_nothing() -> None:
    xyz, _ = two_walls()
    offset = np.array([512_345.0, 5_400_123.0, 812.0])
    far = View.of(offset, perspective(), SIZE)
    lasso = LEFT_HALF + np.array([0.0012, 0.0])
    expected = select_in_lasso(xyz, None, VIEWS[0], lasso, "visible", 0.01)
    got = select_in_lasso(xyz + offset, None, far, lasso, "visible", 0.01)
    np.testing.assert_array_equal(got.indices, expected.indices)


def test_the_tolerance_grows_with_the_pixel_but_not_below_two_millimetres() -> None:
    near, far = np.array([[0, 0, -0.101]]), np.array([[0, 0, -50.0]])
    pixel = 2 * 50.0 * np.tan(np.deg2rad(30.0)) / SIZE[1]
    assert select_in_lasso(near, None, VIEWS[0], EVERYTHING, "visible").tolerance == 0.002
    chosen = select_in_lasso(far, None, VIEWS[0], EVERYTHING, "visible").tolerance
    assert chosen == pytest.approx(5 * pixel, rel=1e-6)


def test_an_empty_catch() -> None:
    got = select_in_lasso(np.empty((0, 3)), None, VIEWS[0], EVERYTHING, "visible")
    assert got.indices.shape == (0,)
    assert got.describe() == "0 selected, 0 hidden, tolerance 2 mm"


def test_the_sentence_states_its_basis() -> None:
    xyz, _ = two_walls()
    seen = select_in_lasso(xyz, None, VIEWS[0], EVERYTHING, "visible", 0.0034)
    assert seen.describe() == "90\u202f000 selected, 90\u202f000 hidden, tolerance 3.4 mm"
    through = select_in_lasso(xyz, None, VIEWS[0], EVERYTHING, "through")
    assert through.describe() == "180\u202f000 selected, through everything"


def test_wrong_use_is_refused() -> None:
    xyz, _ = two_walls()
    with pytest.raises(WrongUse, match="visible"):
        select_in_lasso(xyz, None, VIEWS[0], EVERYTHING, "window")  # type: ignore[arg-type]
    with pytest.raises(BadInput, match="three corners"):
        select_in_lasso(xyz, None, VIEWS[0], EVERYTHING[:2], "through")
