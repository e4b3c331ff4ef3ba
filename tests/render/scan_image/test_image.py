"""The nearest point of each pixel and the points of a region, against loops over points."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.screen.lasso import rasterise_polygon
from app.render.scan_image.image import ScanImage, make_image
from app.render.scan_image.layout import lay_out


@pytest.fixture
def alive(build) -> np.ndarray:
    scan, _, _ = build()
    alive = scan.valid.copy()
    alive[::7] = False
    return alive


@pytest.fixture
def image(build, alive) -> ScanImage:
    return make_image(lay_out(build()[0]), alive)


def find_nearest(image: ScanImage, side: int) -> np.ndarray:
    """One point after the other, in pixels of `side` × `side`."""
    layout = image.layout
    rows, columns = -(-layout.rows // side), -(-layout.columns // side)
    nearest = np.full((rows, columns), -1)
    for point in np.flatnonzero(image.alive):
        pixel = int(layout.pixel[point])
        if pixel < 0:
            continue
        row, column = pixel // layout.columns // side, pixel % layout.columns // side
        other = nearest[row, column]
        if other < 0 or layout.distance[point] < layout.distance[other]:
            nearest[row, column] = point
    return nearest


def test_a_pixel_shows_the_nearest_point_that_is_there(image) -> None:
    assert np.array_equal(image.levels[0], find_nearest(image, 1))
    assert image.shown == np.count_nonzero(image.levels[0] >= 0)


def test_each_level_shows_the_nearest_of_four(build, alive, monkeypatch) -> None:
    monkeypatch.setattr("app.render.scan_image.image.SMALLEST", 3)
    image = make_image(lay_out(build()[0]), alive)
    assert [level.shape for level in image.levels] == [(12, 20), (6, 10), (3, 5), (2, 3)]
    for level, found in enumerate(image.levels):
        assert np.array_equal(found, find_nearest(image, 2**level))


def test_silence_is_shown_only_where_there_is_no_point(image) -> None:
    silent = image.silent[0]
    assert np.array_equal(silent, image.layout.no_return)
    assert not (silent & (image.levels[0] >= 0)).any()


def test_deleted_points_hide_nothing(image) -> None:
    pixels = image.layout.pixel
    counts = np.bincount(pixels[pixels >= 0], minlength=image.levels[0].size)
    shared = int(np.flatnonzero(counts > 1)[0])
    row, column = divmod(shared, image.layout.columns)
    first = image.layout.pixel == shared
    near = np.flatnonzero(first)[np.argsort(image.layout.distance[first])]
    alive = np.ones(len(pixels), bool)
    assert make_image(image.layout, alive).point_at(row, column) == near[0]
    alive[near[0]] = False
    again = make_image(image.layout, alive)
    assert again.point_at(row, column) == near[1]
    assert set(again.points_at(row, column)) == set(near)


@pytest.mark.parametrize(
    "polygon",
    [
        [(2.2, 1.1), (15.0, 2.0), (9.0, 11.9)],
        [(-5.0, -5.0), (30.0, -5.0), (30.0, 40.0), (-5.0, 40.0)],
        [(3.0, 3.0), (8.0, 8.0), (8.0, 3.0), (3.0, 8.0)],
        [(19.4, 11.4), (40.0, 11.4), (40.0, 30.0), (19.4, 30.0)],
    ],
)
def test_a_region_holds_all_points_of_its_pixels(image, polygon) -> None:
    layout = image.layout
    inside = rasterise_polygon(np.array(polygon), (layout.columns, layout.rows))
    expected = [
        point
        for point in np.flatnonzero(image.alive)
        if layout.pixel[point] >= 0 and inside[divmod(int(layout.pixel[point]), layout.columns)]
    ]
    assert image.points_in(np.array(polygon)).tolist() == expected
    assert expected


def test_a_region_beside_the_picture_holds_nothing(image) -> None:
    beside = np.array([(25.0, 1.0), (30.0, 1.0), (30.0, 9.0)])
    assert len(image.points_in(beside)) == 0
    assert len(image.points_in(-beside)) == 0


def test_pixels_light_up_where_a_selected_point_is_shown_or_hidden(image) -> None:
    points = np.arange(0, len(image.alive), 3)
    expected = np.zeros(image.levels[0].shape, bool)
    for point in points:
        place = image.pixel_of(int(point))
        if image.alive[point] and place is not None:
            expected[place] = True
    assert np.array_equal(image.light(points), expected)


def test_places_outside_have_no_point(image) -> None:
    assert image.point_at(-1, 3) == image.point_at(3, 20) == -1
    assert image.pixel_of(6) is None


def test_a_scan_without_points_is_an_empty_picture(image) -> None:
    empty = make_image(image.layout, np.zeros(len(image.alive), bool))
    assert empty.shown == 0
    assert empty.depth == (0.0, 1.0)
