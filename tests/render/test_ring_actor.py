"""Rings in the picture: where they are, in which colour, and that they go."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from app.model.project import Project
from app.model.scene import resolve
from app.model.view_state import ViewState
from app.render.camera import look_at_points
from app.render.picture import ProjectSource
from app.render.ring_actor import COLOURS, RingActor
from app.render.snapshot import render_snapshot

SIZE = (300, 200)
FAR = np.array([500_000.0, 5_400_000.0, 300.0])


def corners() -> np.ndarray:
    return np.stack(np.meshgrid((-1.0, 1.0), (0.0,), (-1.0, 1.0)), axis=-1).reshape(-1, 3) + FAR


def circle(radius: float) -> np.ndarray:
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    around = np.stack((np.cos(turn), np.zeros(60), np.sin(turn)), axis=1)
    return (radius * around + FAR)[None]


@pytest.mark.parametrize("background", ["light", "dark"])
def test_a_circle_far_from_zero_is_where_it_belongs(
    build: Callable[..., tuple[Project, str]], background: str
) -> None:
    project, key = build(corners())
    view = ViewState(key, point_size=1)
    camera = look_at_points(corners(), "front", SIZE[0] / SIZE[1], True)
    scene, source = resolve(project, view), ProjectSource(project, view)

    def draw(rings: np.ndarray | None) -> np.ndarray:
        return render_snapshot(
            scene, source, SIZE, background, camera, legend=False, rings=rings
        ).astype(int)

    plain, ringed = draw(None), draw(circle(0.5))
    changed = (np.abs(plain - ringed).max(axis=2) > 40).nonzero()
    high, wide = (place.max() - place.min() for place in changed)
    height = SIZE[1] / (2 * camera.parallel_scale)
    assert high == pytest.approx(height, abs=3)
    assert wide == pytest.approx(height, abs=3)
    assert np.mean(changed, axis=1) == pytest.approx([99.5, 149.5], abs=1.5)
    strongest = np.abs(plain - ringed).sum(axis=2).argmax()
    colour = ringed.reshape(-1, 3)[strongest] / 255
    assert np.abs(colour - COLOURS[background]).max() < 0.25


def test_nothing_to_show_shows_nothing() -> None:
    rings = RingActor()
    for none in (None, np.empty((0, 36, 3))):
        rings.show(circle(1.0))
        assert rings.actor.GetVisibility()
        assert rings.bounds().shape == (2, 3)
        rings.show(none)
        assert not rings.actor.GetVisibility()
        assert rings.bounds() is None
