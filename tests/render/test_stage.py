from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from app.core.screen import project as project_points
from app.model.operations import Select, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scene import resolve
from app.model.view_state import ColourRange, ViewState
from app.render.camera import Camera, look_at_points, make_orthographic
from app.render.overlay import SELECTED_COLOUR
from app.render.palettes import BACKGROUNDS, MISSING, PLAIN, colour_table, colours
from app.render.picture import ProjectSource
from app.render.snapshot import make_window
from app.render.stage import HAZE, Stage

SIZE = (300, 200)
FAR = np.array([500_000.0, 5_400_000.0, 300.0])
Build = Callable[..., tuple[Project, str]]


class Picture:
    """A stage in a window of its own."""

    def __init__(self) -> None:
        self.stage = Stage("light")
        self.window = make_window()
        self.window.SetSize(*SIZE)
        self.window.AddRenderer(self.stage.renderer)

    def show(self, project: Project, view: ViewState) -> frozenset[str]:
        changed = self.stage.show(resolve(project, view), ProjectSource(project, view))
        self.stage.show_all()
        return changed

    def image(self) -> np.ndarray:
        self.window.Render()
        grab = vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        grab.Update()
        flat = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
        return flat.reshape(SIZE[1], SIZE[0], -1)[::-1, :, :3].copy()

    def pixel(self, xyz: np.ndarray) -> tuple[int, int]:
        view = self.stage.view(SIZE)
        x, y = project_points(xyz[None], view.origin, view.matrix, SIZE).px[0]
        return int(y), int(x)


@pytest.fixture
def picture() -> Iterator[Picture]:
    picture = Picture()
    yield picture
    # An X server that ends before its last window takes the process with it.
    picture.window.Finalize()


def nine_points() -> np.ndarray:
    z, x = np.meshgrid((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), indexing="ij")
    return np.stack((x.ravel(), np.zeros(9), z.ravel()), axis=1) + FAR


def camera_at_nine(orthographic: bool = False) -> Camera:
    return look_at_points(nine_points(), "front", SIZE[0] / SIZE[1], orthographic)


@pytest.mark.parametrize("orthographic", [False, True])
def test_points_fall_where_the_matrix_says_in_their_colours(
    build: Build, picture: Picture, orthographic: bool
) -> None:
    xyz, values = nine_points(), np.linspace(0, 1, 9)
    project, key = build(xyz, {"v": values})
    view = ViewState(key, colour="v", ranges={"v": ColourRange(0.1, 0.8)}, point_size=5)
    picture.show(project, view)
    picture.stage.set_camera(make_orthographic(camera_at_nine(), orthographic))
    image = picture.image()
    expected = colours(values, 0.1, 0.8, "cividis")[:, :3]
    for point, colour in zip(xyz, expected, strict=True):
        row, column = picture.pixel(point)
        assert np.abs(image[row, column].astype(int) - colour).max() <= 1
    # Nothing but the nine squares of 5 × 5 pixels differs from the empty stage.
    picture.stage.show_blocks(0, 0)
    assert (picture.image() != image).any(axis=2).sum() == 9 * 25


def test_a_point_lands_within_a_pixel_far_from_the_origin(build: Build, picture: Picture) -> None:
    rng = np.random.default_rng(5)
    empty = picture.image()
    for xyz in FAR + rng.uniform(-0.6, 0.6, (12, 3)):
        project, key = build(xyz[None])
        picture.show(project, ViewState(key, point_size=1))
        picture.stage.set_camera(camera_at_nine())
        drawn = (picture.image() != empty).any(axis=2)
        found = np.argwhere(drawn)
        assert len(found) == 1
        assert np.abs(found[0] - picture.pixel(xyz)).max() <= 1
        picture.stage.clear()


def test_missing_values_have_their_own_colour(build: Build, picture: Picture) -> None:
    values = np.full(9, np.nan)
    values[0] = np.inf
    project, key = build(nine_points(), {"v": values})
    picture.show(project, ViewState(key, colour="v", point_size=3))
    picture.stage.set_camera(camera_at_nine())
    image = picture.image()
    for point in nine_points():
        assert np.abs(image[picture.pixel(point)].astype(int) - MISSING["light"]).max() <= 1


@pytest.mark.parametrize("orthographic", [False, True])
def test_plain_points_fade_with_depth(build: Build, picture: Picture, orthographic: bool) -> None:
    xyz = nine_points()
    xyz[:, 1] += np.linspace(0, 2, 9)
    project, key = build(xyz)
    picture.show(project, ViewState(key, point_size=3))
    picture.stage.set_camera(make_orthographic(camera_at_nine(), orthographic))
    image = picture.image()
    shown = np.array([image[picture.pixel(point)] for point in xyz]).astype(float)
    plain, haze = np.array(PLAIN["light"]), np.array(BACKGROUNDS["light"][1])
    share = ((shown - plain) / (haze - plain)).mean(axis=1)
    assert np.allclose(shown, plain + share[:, None] * (haze - plain), atol=1)
    assert share[0] == pytest.approx(0, abs=0.04)
    assert share[-1] == pytest.approx(HAZE, abs=0.04)
    assert np.allclose(np.diff(share), HAZE / 8, atol=0.015)


def test_points_that_are_not_finite_are_left_out(build: Build, picture: Picture) -> None:
    xyz = nine_points()
    xyz[3, 1], xyz[7, 0] = np.nan, np.inf
    project, key = build(xyz)
    picture.show(project, ViewState(key))
    assert picture.stage.show_all() == 7
    bounds = picture.stage.bounds()
    assert bounds is not None
    assert np.allclose(bounds, np.add(FAR, [(-1, 0, -1), (1, 0, 1)]))


def test_recolouring_and_a_new_range_leave_geometry_alone(build: Build, picture: Picture) -> None:
    xyz = nine_points()
    project, key = build(xyz, {"v": np.linspace(0, 1, 9), "w": np.linspace(1, 0, 9)})
    view = ViewState(key, colour="v", ranges={"v": ColourRange(0, 1), "w": ColourRange(0, 1)})
    picture.show(project, view)
    (actor,) = picture.stage._clouds.values()
    before = [(d.GetPoints().GetMTime(), d.GetVerts().GetMTime()) for d in actor._data]
    picture.stage.set_camera(camera_at_nine())
    first = picture.image()
    for other in (
        replace_view(view, colour="w"),
        replace_view(view, ranges={"v": ColourRange(0, 0.5)}),
        replace_view(view, maps={"v": "viridis"}),
    ):
        assert not picture.show(project, other) & {"points", "mask"}
        assert (picture.image() != first).any()
    after = [(d.GetPoints().GetMTime(), d.GetVerts().GetMTime()) for d in actor._data]
    assert before == after
    assert (actor,) == tuple(picture.stage._clouds.values())


def replace_view(view: ViewState, **changes: object) -> ViewState:
    import msgspec

    return msgspec.structs.replace(view, **changes)


def test_deleted_points_go_and_come_back(build: Build, picture: Picture) -> None:
    project, key = build(nine_points())
    view = ViewState(key, point_size=3)
    picture.show(project, view)
    picture.stage.set_camera(camera_at_nine())
    whole = picture.image()
    project.do(SetDeleted(key, PointSet([0, 1, 2])))
    assert picture.show(project, view) == {"mask"}
    assert picture.stage.show_all() == 6
    assert (picture.image() != whole).any(axis=2).sum() == 3 * 9
    project.undo()
    picture.show(project, view)
    assert (picture.image() == whole).all()


def test_selection_changes_colours_and_nothing_else(build: Build, picture: Picture) -> None:
    project, key = build(nine_points(), {"v": np.zeros(9)})
    view = ViewState(key, colour="v", ranges={"v": ColourRange(0, 1)}, point_size=3)
    picture.show(project, view)
    picture.stage.set_camera(camera_at_nine())
    project.do(Select(key, PointSet([4])))
    assert picture.show(project, view) == {"overlay"}
    image = picture.image()
    strength = SELECTED_COLOUR[3] / 255
    plain = colour_table("cividis")[0, :3]
    mixed = (1 - strength) * plain + strength * np.array(SELECTED_COLOUR[:3])
    row, column = picture.pixel(nine_points()[4])
    assert np.abs(image[row, column] - mixed).max() <= 1.5
    assert np.abs(image[picture.pixel(nine_points()[0])] - plain.astype(int)).max() <= 1


def test_refining_step_by_step_gives_the_same_picture_as_drawing_all(
    build: Build, picture: Picture
) -> None:
    rng = np.random.default_rng(6)
    xyz = FAR + rng.uniform(-1, 1, (300_000, 3))
    project, key = build(xyz, {"v": xyz[:, 1]})
    picture.show(project, ViewState(key, colour="v"))
    picture.stage.set_camera(camera_at_nine())
    whole = picture.image()
    blocks = picture.stage.blocks
    assert len(blocks) == 4
    drawn = picture.stage.show_blocks(0, 1)
    coarse = picture.image()
    picture.stage.draw_over(True)
    for i in range(1, len(blocks)):
        drawn += picture.stage.show_blocks(i, i + 1)
        step = picture.image()
    assert drawn == len(xyz)
    assert (coarse != whole).any()
    assert (step == whole).all()


def test_backgrounds_differ_and_scans_that_went_are_gone(build: Build, picture: Picture) -> None:
    project, key = build(nine_points())
    picture.show(project, ViewState(key))
    picture.show(project, ViewState(key, hidden=(key,)))
    assert picture.stage.renderer.GetActors().GetNumberOfItems() == 0
    for background in ("light", "dark"):
        picture.stage.set_background(background)
        image = picture.image().astype(int)
        assert np.abs(image[0, 0] - BACKGROUNDS[background][0]).max() <= 2
        assert np.abs(image[-1, 0] - BACKGROUNDS[background][1]).max() <= 2


def test_a_stray_does_not_shrink_the_scene(build: Build, picture: Picture) -> None:
    xyz = np.random.default_rng(7).uniform(-1, 1, (20_000, 3))
    xyz[17] = 900.0
    project, key = build(xyz)
    picture.show(project, ViewState(key))
    assert np.abs(picture.stage.extent()).max() < 1.1
    bounds = picture.stage.bounds()
    assert bounds is not None
    assert bounds[1].max() == pytest.approx(900)
