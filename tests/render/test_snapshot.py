from __future__ import annotations

import io
from collections.abc import Callable

import matplotlib.image
import numpy as np
import pytest

from app.model.project import Project
from app.model.scene import Scene, resolve
from app.model.view_state import ViewState
from app.render.legend import legend_height
from app.render.palettes import BACKGROUNDS, colour_table
from app.render.picture import ProjectSource
from app.render.snapshot import png_bytes, render_snapshot

Build = Callable[..., tuple[Project, str]]
SIZE = (480, 300)


def wall() -> np.ndarray:
    y, z = np.meshgrid(np.linspace(-1.5, 1.5, 300), np.linspace(-1, 1, 200))
    return np.stack((np.full(y.size, 4.0), y.ravel(), z.ravel()), axis=1)


@pytest.mark.parametrize("background", ["light", "dark"])
def test_the_scanner_sees_low_values_on_its_left(build: Build, background: str) -> None:
    xyz = wall()
    project, key = build(xyz, {"v": -xyz[:, 1]})
    view = ViewState(key, colour="v", point_size=3)
    image = render_snapshot(
        resolve(project, view), ProjectSource(project, view), SIZE, background, scanner=np.zeros(3)
    ).astype(int)
    assert image.shape == (300, 480, 3)
    table = colour_table("cividis").astype(int)
    # Looking along +x with z up, +y lies on the left.
    middle = (300 - legend_height(SIZE)) // 2
    assert np.abs(image[middle, 60] - table[8, :3]).max() < 25
    assert np.abs(image[middle, 420] - table[247, :3]).max() < 25
    assert np.abs(image[-1, 0] - BACKGROUNDS[background][1]).max() <= 2


def test_the_legend_shows_the_whole_map_below_the_scene(build: Build) -> None:
    xyz = wall()
    project, key = build(xyz, {"v": xyz[:, 1]})
    view = ViewState(key, colour="v", maps={"v": "viridis"})
    scene, source = resolve(project, view), ProjectSource(project, view)
    image = render_snapshot(scene, source, SIZE, scanner=np.zeros(3)).astype(int)
    plain = render_snapshot(scene, source, SIZE, scanner=np.zeros(3), legend=False)
    assert plain.shape == image.shape
    strip = image[-legend_height(SIZE) :].reshape(-1, 3)
    for row in (0, 64, 128, 192, 255):
        nearest = np.abs(strip - colour_table("viridis")[row, :3].astype(int)).max(axis=1).min()
        assert nearest <= 3


def test_an_empty_scene_is_background() -> None:
    project = Project()
    image = render_snapshot(Scene(), ProjectSource(project, ViewState()), (64, 40), legend=False)
    assert image.shape == (40, 64, 3)
    assert image.std() < 20


def test_png_holds_the_picture_and_its_texts() -> None:
    image = np.random.default_rng(1).integers(0, 255, (20, 30, 3), dtype=np.uint8)
    data = png_bytes(image, Title="a leaf")
    assert b"a leaf" in data
    read = matplotlib.image.imread(io.BytesIO(data))
    assert (np.round(read[..., :3] * 255) == image).all()
