"""The scan image as a picture file would hold it."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.operations import Select, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Pose, Scan
from app.model.scene import resolve
from app.model.view_state import ColourRange, ViewState
from app.render.legend import legend_height
from app.render.overlay import SELECTED_COLOUR
from app.render.palettes import BACKGROUNDS, colour_table
from app.render.picture import ProjectSource
from app.render.scan_image.image import make_image
from app.render.scan_image.layout import lay_out
from app.render.scan_image.picture import render_scan_image
from app.services.opening import add_scans

SIZE = (480, 300)


@pytest.fixture
def wall() -> tuple[Project, str]:
    y, z = np.meshgrid(np.linspace(-1.5, 1.5, 300), np.linspace(-0.5, 0.5, 200))
    xyz = np.stack((np.full(y.size, 4.0), y.ravel(), z.ravel()), axis=1)
    project = Project()
    scan = Scan("wall", xyz, {"v": -xyz[:, 1]}, pose=Pose((0.0, 0.0, 0.0)))
    (key,) = add_scans(project, [scan])
    return project, key


def draw(project: Project, key: str, background: str = "light") -> np.ndarray:
    project.field(key, "v")
    view = ViewState(key, colour="v", ranges={"v": ColourRange(-1.5, 1.5)})
    state = project.state.scan(key)
    image = make_image(lay_out(state.scan), state.alive)
    source = ProjectSource(project, view)
    return render_scan_image(resolve(project, view), source, key, image, SIZE, background).astype(
        int
    )


@pytest.mark.parametrize("background", ["light", "dark"])
def test_the_scanner_sees_low_values_on_its_left(wall, background: str) -> None:
    drawn = draw(*wall, background)
    assert drawn.shape == (300, 480, 3)
    table = colour_table("cividis").astype(int)
    middle = (300 - legend_height(SIZE)) // 2
    for column in (10, 120, 240, 360, 470):
        # Columns are equal steps of the azimuth, values of its tangent.
        reach = np.arctan(1.5 / 4)
        value = 4 * np.tan((column / 480 * 2 - 1) * reach)
        row = round((value + 1.5) / 3 * 255)
        assert np.abs(drawn[middle, column] - table[row, :3]).max() < 12
    assert drawn[1, 1].tolist() == list(BACKGROUNDS[background][1])


def test_selected_points_are_lit_and_deleted_ones_gone(wall) -> None:
    project, key = wall
    xyz = project.state.scan(key).scan.xyz
    project.do(Select(key, PointSet.from_mask(xyz[:, 1] > 0.5)))
    project.do(SetDeleted(key, PointSet.from_mask(xyz[:, 1] < -0.5)))
    drawn = draw(project, key)
    middle = (300 - legend_height(SIZE)) // 2
    assert np.abs(drawn[middle, 60] - np.array(SELECTED_COLOUR[:3])).max() < 60
    assert drawn[middle, 430].tolist() == list(BACKGROUNDS["light"][1])
