"""From where a ghost is looked at: nothing hides it, and a picture that was turned stays so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.render.camera import Camera, turn
from widgets.common.ghosts.sight import (
    VIEWS,
    choose_view,
    count_hiding,
    is_turned,
    look_across,
    reach_around,
)

SCANNER, GHOST, REACH = np.zeros(3), np.array([3.0, 0.2, 0.1]), 0.1
CAMERA = Camera((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def make_sheet(camera: Camera, away: float, half: float = 0.05) -> np.ndarray:
    """A leaf across the way from a camera to the ghost."""
    right, up, forward = camera.axes()
    side = np.linspace(-half, half, 41)
    y, x = (a.ravel()[:, None] for a in np.meshgrid(side, side))
    return GHOST - away * forward + x * right + y * up


def look(xyz: np.ndarray, alive: np.ndarray | None = None) -> Camera:
    alive = np.ones(len(xyz), bool) if alive is None else alive
    return choose_view(CAMERA, xyz, alive, GHOST, SCANNER, REACH)


def view(number: int) -> Camera:
    return look_across(CAMERA, GHOST, SCANNER, VIEWS[number])


def test_the_usual_view_is_taken_where_nothing_hides_the_ghost() -> None:
    assert look(GHOST[None]) == view(0)
    behind = make_sheet(view(0), -0.1)
    beyond_the_viewer = make_sheet(view(0), 1.5)
    assert look(np.concatenate([behind, beyond_the_viewer])) == view(0)


def test_a_leaf_before_the_ghost_is_looked_around() -> None:
    leaf = make_sheet(view(0), 0.1)
    assert count_hiding(view(0), leaf - GHOST, 0.12 * REACH) > 10
    assert look(leaf) == view(1)
    both = np.concatenate([leaf, make_sheet(view(1), 0.1)])
    assert look(both) not in (view(0), view(1))
    assert look(leaf, np.zeros(len(leaf), bool)) == view(0), "what is deleted hides nothing"


def test_among_leaves_all_around_the_scanner_s_own_view_is_left() -> None:
    leaves = np.concatenate([make_sheet(view(k), 0.1) for k in range(len(VIEWS) - 1)])
    right, up, forward = view(-1).axes()
    off = leaves - GHOST
    beside = np.hypot(off @ right, off @ up)
    free = leaves[(beside > 0.03) | (off @ forward > 0)]  # the beam came through
    chosen = look(free)
    assert chosen == view(-1)
    sight = np.subtract(chosen.focal_point, chosen.position)
    assert sight @ GHOST / np.linalg.norm(sight) / np.linalg.norm(GHOST) == pytest.approx(1.0)


def test_a_turn_is_noticed_and_a_shift_is_none() -> None:
    camera = view(0)
    assert not is_turned(camera, camera)
    shift = replace(
        camera,
        position=tuple(np.add(camera.position, 0.3).tolist()),
        focal_point=tuple(np.add(camera.focal_point, 0.3).tolist()),
    )
    assert not is_turned(shift, camera)
    assert is_turned(turn(camera, 0.05, 0.0), camera)
    assert is_turned(turn(camera, 0.0, 0.05), camera)


def test_what_is_seen_around_a_ghost_is_bounded() -> None:
    assert reach_around(GHOST, SCANNER, 2.0) == 0.2
    assert reach_around(0.01 * GHOST, SCANNER, 0.0) == 0.03
