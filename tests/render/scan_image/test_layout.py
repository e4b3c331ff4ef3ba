"""Which pixel a point gets, against the cell that it was made in."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import MissingScanner
from app.model.scan import Grid, Pose, Scan
from app.render.scan_image import layout as layout_module
from app.render.scan_image.directions import Turn, follow_lines, set_step, unroll
from app.render.scan_image.layout import lay_out

ROWS, COLUMNS, STEP = 12, 20, 0.5


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_grid_stands_upright_however_the_file_counts(
    build, swap: bool, upside_down: bool, mirrored: bool
) -> None:
    scan, cell, free = build(swap, upside_down, mirrored)
    layout = lay_out(scan)
    assert (layout.rows, layout.columns, layout.kind) == (ROWS, COLUMNS, "scan grid")
    there = np.ones(len(cell), bool)
    there[[5, 6]] = False
    assert np.array_equal(layout.pixel[there], cell[there])
    assert (layout.pixel[~there] == -1).all()
    assert np.array_equal(np.flatnonzero(layout.no_return), np.sort(free))


@pytest.mark.parametrize("swap", [False, True])
def test_a_pixel_knows_its_cell_in_the_file(build, swap: bool) -> None:
    scan, _, _ = build(swap, True, True)
    layout = lay_out(scan)
    for point in np.flatnonzero(layout.pixel >= 0)[::17]:
        row, column = divmod(int(layout.pixel[point]), layout.columns)
        expected = int(scan.grid.row[point]), int(scan.grid.column[point])
        assert layout.find_cell(row, column) == expected


def test_lines_have_their_angles_and_follow_the_circle(build) -> None:
    scan, _, _ = build()
    layout = lay_out(scan)
    assert np.allclose(layout.elevation, 10.0 - STEP * np.arange(ROWS), atol=1e-4)
    azimuth = 170.0 - STEP * (np.arange(COLUMNS) - COLUMNS / 2)
    assert np.allclose((layout.azimuth - azimuth + 180) % 360 - 180, 0.0, atol=1e-4)
    assert (np.diff(layout.azimuth) < 0).all()
    assert layout.shape == pytest.approx(np.cos(np.deg2rad(layout.elevation.mean())), rel=1e-3)


def test_distances_are_those_from_the_scanner(build) -> None:
    scan, _, _ = build()
    expected = np.linalg.norm(scan.xyz - np.array(scan.pose.position), axis=1)
    expected[6] = np.nan
    assert np.allclose(lay_out(scan).distance, expected, rtol=1e-6, equal_nan=True)


def test_without_a_grid_pixels_are_steps_of_the_angles(point_at) -> None:
    chance = np.random.default_rng(5)
    azimuth, elevation = chance.uniform(100, 260, 4000), chance.uniform(-30, 30, 4000)
    xyz = point_at(azimuth, elevation, chance.uniform(2, 5, 4000))
    layout = lay_out(Scan("s", xyz, pose=Pose((1.0, -2.0, 0.5))))
    assert layout.kind == "angles"
    row, column = np.divmod(layout.pixel, layout.columns)
    step = layout.elevation[0] - layout.elevation[1]
    assert np.abs(layout.elevation[row] - elevation).max() <= 0.501 * step
    away = (layout.azimuth[column] - azimuth + 180) % 360 - 180
    assert np.abs(away).max() <= 0.501 * step
    filled = len(np.unique(layout.pixel))
    assert 0.7 * layout.rows * layout.columns < filled < len(azimuth)


def test_a_large_grid_has_several_cells_to_a_pixel(build, monkeypatch) -> None:
    monkeypatch.setattr(layout_module, "MOST_PIXELS", 40)
    scan, cell, free = build()
    layout = lay_out(scan)
    assert layout.merged == 3
    assert (layout.rows, layout.columns) == (4, 7)
    row, column = np.divmod(np.delete(cell, [5, 6]), COLUMNS)
    assert np.array_equal(np.delete(layout.pixel, [5, 6]), row // 3 * 7 + column // 3)
    row, column = np.divmod(free, COLUMNS)
    assert np.array_equal(np.flatnonzero(layout.no_return), np.unique(row // 3 * 7 + column // 3))
    assert layout.find_cell(1, 2) == (3, 6)


def test_without_a_position_there_is_no_picture(build) -> None:
    scan, _, _ = build()
    with pytest.raises(MissingScanner, match="scan image"):
        lay_out(scan.with_pose(None))


@pytest.mark.parametrize("count", [0, 1])
def test_hardly_any_points_are_a_small_picture(count: int) -> None:
    layout = lay_out(Scan("s", np.ones((count, 3)), pose=Pose((0.0, 0.0, 0.0))))
    assert (layout.rows, layout.columns) == (1, 1)
    assert layout.pixel.tolist() == [0] * count
    assert layout.shape > 0


def test_cells_outside_the_grid_are_left_out(build) -> None:
    scan, _, _ = build()
    row = scan.grid.row.copy()
    row[10] = ROWS + 3
    damaged = Grid(ROWS, COLUMNS, row, scan.grid.column)
    assert lay_out(Scan("s", scan.xyz, pose=scan.pose, grid=damaged)).pixel[10] == -1


def test_lines_without_points_lie_evenly_between_the_others() -> None:
    angle, line = np.array([10.0, 12.0, 4.0]), np.array([2, 2, 6])
    assert follow_lines(angle, line, 9).tolist() == pytest.approx(
        [13.5 + 1.0, 12.75, 11.0, 9.25, 7.5, 5.75, 4.0, 2.25, 0.5]
    )
    around = follow_lines(np.array([179.0, -179.0]), np.array([0, 1]), 2, turns=True)
    assert around.tolist() == pytest.approx([179.0, 181.0])


def test_the_picture_begins_at_the_widest_gap() -> None:
    turn, start = unroll(np.array([-170.0, 175.0, 160.0]))
    assert turn.tolist() == pytest.approx([0.0, 15.0, 30.0])
    assert start == pytest.approx(-170.0)


def test_no_cloud_makes_more_pixels_than_allowed() -> None:
    turn = np.linspace(0.0, 359.0, 100_000)
    step = set_step(turn, turn[::-1] / 3, 10_000)
    assert (359.0 / step + 1) * (359.0 / 3 / step + 1) <= 10_600


def test_turning_there_and_back() -> None:
    turn = Turn(ROWS, COLUMNS, True, (False, True))
    row, column = turn.place(np.array([3]), np.array([5]))
    assert turn.find_cell(int(row[0]), int(column[0])) == (3, 5)
