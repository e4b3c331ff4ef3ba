"""What a picture of a leaf is made to hold."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.services.wrinkles.picture import choose_framed, frame_leaf


@pytest.fixture
def leaf():
    """A flat leaf of 40 × 60 mm three metres ahead, and a tenth of ghosts half a metre behind."""
    y, z = (a.ravel() for a in np.meshgrid(np.linspace(0, 0.04, 20), np.linspace(0, 0.06, 30)))
    xyz = np.column_stack((np.full(len(y), 3.0), y, z))
    xyz[::10, 0] += 0.5
    plane = SimpleNamespace(point=np.array([3.0, 0.0, 0.0]), normal=np.array([-1.0, 0.0, 0.0]))
    angles = SimpleNamespace(valid=np.ones(len(y), bool))
    return SimpleNamespace(xyz=xyz), SimpleNamespace(plane=plane, angles=angles)


def test_ghosts_do_not_shrink_the_leaf(leaf) -> None:
    measured, judged = leaf
    framed = choose_framed(measured, judged)
    assert (framed == (measured.xyz[:, 0] == 3.0)).all()
    x, y = 1000.0 * (measured.xyz[framed, 0] - 3.0), 1000.0 * measured.xyz[framed, 2]
    left, low, side = frame_leaf(x, y)
    assert 60.0 < side < 80.0
    assert left < 0.0 < left + side
    assert low < 30.0 < low + side


def test_a_leaf_without_a_valid_point_is_framed_all_the_same(leaf) -> None:
    measured, judged = leaf
    judged.angles.valid[:] = False
    assert (choose_framed(measured, judged) == (measured.xyz[:, 0] == 3.0)).all()


def test_points_all_far_from_the_plane_still_have_a_frame(leaf) -> None:
    measured, judged = leaf
    measured.xyz[:, 0] += 1.0
    assert choose_framed(measured, judged).any()
