from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.screen import View, project

SIZE = (800, 500)
ORIGIN = np.array([250_000.0, 4_100_000.0, 300.0])


def vtk_camera(parallel: bool = False):  # type: ignore[no-untyped-def]
    from vtkmodules.vtkRenderingCore import vtkCamera

    camera = vtkCamera()
    camera.SetPosition(3.0, -4.0, 2.0)
    camera.SetFocalPoint(0.5, 0.3, 0.1)
    camera.SetViewUp(0.1, 0.0, 1.0)
    camera.SetViewAngle(35.0)
    camera.SetParallelProjection(parallel)
    camera.SetParallelScale(2.0)
    camera.SetClippingRange(0.5, 20.0)
    return camera


def matrix_of(camera) -> np.ndarray:  # type: ignore[no-untyped-def]
    matrix = camera.GetCompositeProjectionTransformMatrix(SIZE[0] / SIZE[1], -1.0, 1.0)
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])


def by_trigonometry(camera, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[no-untyped-def]
    """Pixels and depths from the camera's axes, without any matrix."""
    eye = np.array(camera.GetPosition())
    forward = np.array(camera.GetDirectionOfProjection())
    right = np.cross(forward, camera.GetViewUp())
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    depth = (local - eye) @ forward
    half = np.full(len(local), camera.GetParallelScale())
    if not camera.GetParallelProjection():
        half = depth * np.tan(np.deg2rad(camera.GetViewAngle()) / 2)
    scale = SIZE[1] / 2 / half
    x = SIZE[0] / 2 + (local - eye) @ right * scale
    y = SIZE[1] / 2 - (local - eye) @ up * scale
    return np.column_stack([x, y]), depth


def cloud(n: int = 2000) -> np.ndarray:
    return np.random.default_rng(11).uniform(-3.0, 3.0, (n, 3))


@pytest.mark.parametrize("parallel", [False, True])
def test_pixels_and_depth_agree_with_trigonometry(parallel: bool) -> None:
    camera, local = vtk_camera(parallel), cloud()
    got = project(local + ORIGIN, ORIGIN, matrix_of(camera), SIZE)
    px, depth = by_trigonometry(camera, local)
    shown = (px >= 0).all(axis=1) & (px < SIZE).all(axis=1) & (depth >= 0.5) & (depth <= 20.0)
    assert 0.1 < shown.mean() < 1.0
    np.testing.assert_array_equal(got.inside, shown)
    np.testing.assert_allclose(got.px[shown], px[shown], atol=2e-3)
    # Orthographic depth has a zero of its own.
    shift = np.median(depth[shown] - got.depth[shown]) if parallel else 0.0
    np.testing.assert_allclose(got.depth[shown] + shift, depth[shown], atol=1e-5)


@pytest.mark.parametrize("parallel", [False, True])
def test_a_pixel_is_as_large_as_the_step_to_the_next(parallel: bool) -> None:
    camera = vtk_camera(parallel)
    view = View.of((0, 0, 0), matrix_of(camera), SIZE)
    forward = np.array(camera.GetDirectionOfProjection())
    up = np.cross(np.cross(forward, camera.GetViewUp()), forward)
    base = np.array(camera.GetPosition()) + 4.0 * forward
    step = view.pixel_size(4.0) * up / np.linalg.norm(up)
    both = project(np.array([base, base + step]), (0, 0, 0), view.matrix, SIZE)
    assert both.px[0, 1] - both.px[1, 1] == pytest.approx(1.0, abs=1e-3)


def test_points_behind_the_camera_and_not_finite_are_outside() -> None:
    camera = vtk_camera()
    eye, forward = np.array(camera.GetPosition()), np.array(camera.GetDirectionOfProjection())
    xyz = np.array([eye - 2 * forward, eye, eye + 2 * forward, eye * np.nan, eye + np.inf])
    xyz = np.vstack([xyz, [[np.nan, 0, 0]], [[-np.inf, np.inf, 0]]])
    got = project(xyz, (0, 0, 0), matrix_of(camera), SIZE)
    assert got.inside.tolist() == [False, False, True, False, False, False, False]
    assert np.isnan(got.px[0]).all()


def test_orthographic_near_plane_cuts_what_is_behind_the_camera() -> None:
    camera = vtk_camera(parallel=True)
    eye, forward = np.array(camera.GetPosition()), np.array(camera.GetDirectionOfProjection())
    got = project(np.array([eye - forward, eye + forward]), (0, 0, 0), matrix_of(camera), SIZE)
    assert got.inside.tolist() == [False, True]


finite = st.floats(-50.0, 50.0)
rows = st.lists(st.floats(-10.0, 10.0), min_size=16, max_size=16)


@settings(deadline=None)
@given(rows, st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=20))
def test_inside_means_on_the_screen_for_any_matrix(values: list[float], points: list) -> None:
    matrix = np.array(values).reshape(4, 4)
    assume(abs(np.linalg.det(matrix[[0, 1, 3], :3])) > 1e-3)
    got = project(np.array(points), (1.0, 2.0, 3.0), matrix, SIZE)
    on_screen = got.px[got.inside]
    assert ((on_screen >= 0) & (on_screen < SIZE)).all()
    w = (np.array(points) - (1.0, 2.0, 3.0)) @ matrix[3, :3] + matrix[3, 3]
    assert not got.inside[w < -1e-9].any()


@settings(deadline=None)
@given(st.floats(0.3, 3.0), st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_moving_along_a_ray_of_sight_keeps_the_pixel(far: float, x: float, y: float) -> None:
    camera = vtk_camera()
    eye, forward = np.array(camera.GetPosition()), np.array(camera.GetDirectionOfProjection())
    ray = forward + np.array([x, y, x - y])
    pair = np.array([eye + 2.0 * ray, eye + (2.0 + far) * ray])
    got = project(pair, (0, 0, 0), matrix_of(camera), SIZE)
    np.testing.assert_allclose(got.px[0], got.px[1], atol=1e-2)
    assert got.depth[0] < got.depth[1]


def test_read_only_and_strided_input_give_the_same() -> None:
    matrix, xyz = matrix_of(vtk_camera()), cloud()
    expected = project(xyz, (0, 0, 0), matrix, SIZE)
    strided = np.asfortranarray(xyz)
    strided.flags.writeable = False
    got = project(strided, (0, 0, 0), matrix, SIZE)
    np.testing.assert_array_equal(got.px, expected.px)
    np.testing.assert_array_equal(got.depth, expected.depth)


@pytest.mark.parametrize(
    ("origin", "matrix", "size"),
    [
        ((0, 0, 0), np.eye(4), (0, 10)),
        ((0, 0, 0), np.eye(4) * np.nan, (10, 10)),
        ((0, np.inf, 0), np.eye(4), (10, 10)),
        ((0, 0, 0), np.eye(3), (10, 10)),
        ((0, 0), np.eye(4), (10, 10)),
        ((0, 0, 0), np.zeros((4, 4)), (10, 10)),
        ((0, 0, 0), np.diag([1.0, 1.0, 0.0, 1.0]), (10, 10)),
    ],
)
def test_a_view_that_is_none_is_refused(origin, matrix, size) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(BadInput):
        View.of(origin, matrix, size)


def test_views_compare_and_hash_by_value() -> None:
    one = View.of((0, 0, 0), np.eye(4), (10, 10))
    assert one == View.of(np.zeros(3), np.eye(4).tolist(), (10, 10))
    assert len({one, View.of((0, 0, 0), np.eye(4), (10, 11))}) == 2
