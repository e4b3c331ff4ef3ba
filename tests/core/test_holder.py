"""The axis of a holder: exact on exact planes, near on noisy ones, refused where it is open."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.core.holder import Axis, SeenPlane, fit_axis, turn_points, turn_vectors

POINT, DIRECTION = np.array([2.0, 0.1, 1.5]), np.array([0.05, -0.02, 1.0])
AXIS = Axis.through(POINT, DIRECTION)
LEAVES = [
    (np.array([-0.95, 0.2, 0.1]), np.array([1.97, 0.05, 1.45])),
    (np.array([-0.99, -0.1, 0.0]), np.array([2.05, 0.22, 1.52])),
]
ANGLES = np.deg2rad(np.arange(0.0, 86.0, 5.0))


def see(leaves: int, whole: bool, noise: float = 0.0, seed: int = 0) -> list[SeenPlane]:
    """Planes of leaves at all angles, facing a scanner at the origin."""
    rng = np.random.default_rng(seed)
    planes = []
    for number, (normal, place) in enumerate(LEAVES[:leaves]):
        for angle in ANGLES:
            turned = turn_vectors(normal / np.linalg.norm(normal), AXIS.direction, angle)
            turned = turned + noise * rng.standard_normal(3)
            at = turn_points(place[None], AXIS, angle)[0] + 0.1 * noise * rng.standard_normal(3)
            turned *= -np.sign(turned @ at) / np.linalg.norm(turned)
            planes.append(SeenPlane(number, float(angle), turned, at, 1.0, whole))
    return planes


def distance(axis: Axis) -> float:
    """From the true axis, metres."""
    return float(np.linalg.norm(np.cross(axis.point - POINT, AXIS.direction)))


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_turns_add_up_and_keep_lengths(first: float, second: float) -> None:
    xyz = np.array([[1.0, 2.0, 3.0], [0.3, -0.2, 0.1]])
    twice = turn_points(turn_points(xyz, AXIS, first), AXIS, second)
    np.testing.assert_allclose(twice, turn_points(xyz, AXIS, first + second), atol=1e-12)
    before, after = xyz - AXIS.point, twice - AXIS.point
    np.testing.assert_allclose(after @ AXIS.direction, before @ AXIS.direction, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1))


def test_it_turns_by_the_right_hand_rule() -> None:
    up = Axis.through([0, 0, 0], [0, 0, 2])
    turned = turn_points(np.array([[1.0, 0.0, 5.0]]), up, np.pi / 2)
    np.testing.assert_allclose(turned, [[0.0, 1.0, 5.0]], atol=1e-15)


@pytest.mark.parametrize(("leaves", "whole"), [(1, False), (2, False), (2, True)])
def test_exact_planes_give_the_axis(leaves: int, whole: bool) -> None:
    found = fit_axis(see(leaves, whole))
    np.testing.assert_allclose(found.axis.direction, AXIS.direction, atol=3e-3)
    assert distance(found.axis) < 2e-4  # the wish to be near the leaves pulls a little
    assert found.tilt_rms < 1e-3
    assert found.offset_rms < 1e-4
    assert found.planes == leaves * len(ANGLES)


def test_noisy_planes_and_a_few_wrong_ones() -> None:
    planes = see(2, True, noise=0.01, seed=3)
    wrong = SeenPlane(0, planes[3].angle, np.array([0.0, 1.0, 0.0]), planes[3].point + 0.05)
    found = fit_axis([*planes, wrong])
    assert np.rad2deg(np.arccos(found.axis.direction @ AXIS.direction)) < 0.7
    assert distance(found.axis) < 2e-3
    true = LEAVES[1][0] / np.linalg.norm(LEAVES[1][0])
    assert np.rad2deg(np.arccos(abs(found.normals[1] @ true))) < 0.5


def test_a_holder_that_hardly_turned_tells_no_axis() -> None:
    planes = [plane for plane in see(1, False) if plane.angle == 0.0]
    with pytest.raises(BadInput, match="2° or more"):
        fit_axis(planes)
    with pytest.raises(BadInput, match="2° or more"):
        fit_axis([])


@pytest.mark.parametrize("direction", [(0, 0, 0), (np.nan, 0, 1), (1, 2)])
def test_no_axis(direction: tuple[float, ...]) -> None:
    with pytest.raises(WrongUse, match="six numbers"):
        Axis.through((0, 0, 0), direction)
