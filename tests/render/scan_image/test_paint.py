"""Colours of pixels, against those of the points that they show."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.scene import ColourBar
from app.render.overlay import SELECTED_COLOUR, LeafMark, Overlay
from app.render.palettes import BACKGROUNDS, MISSING, colours
from app.render.scan_image.image import ScanImage, make_image
from app.render.scan_image.layout import lay_out
from app.render.scan_image.paint import SILENT, Paint

WHOLE = (slice(None), slice(None))
BAR = ColourBar("x", "x", "", "scalar", "viridis", 10.0, 200.0)


@pytest.fixture
def image(build) -> ScanImage:
    scan, _, _ = build()
    return make_image(lay_out(scan), scan.valid)


@pytest.fixture
def values(image) -> np.ndarray:
    values = np.arange(float(len(image.alive)))
    values[::9] = np.nan
    return values


def draw(paint: Paint, image: ScanImage, level: int = 0) -> np.ndarray:
    drawn = paint.draw(image, level, WHOLE)
    assert (drawn >> 24 == 255).all()
    return np.stack([(drawn >> shift) & 255 for shift in (16, 8, 0)], axis=-1).astype(int)


def mix(colour, mark) -> np.ndarray:
    strength = mark[3] / 255
    return np.array(colour) * (1 - strength) + np.array(mark[:3]) * strength


@pytest.mark.parametrize("background", ["light", "dark"])
@pytest.mark.parametrize("name", ["viridis", "leaves"])
def test_pixels_have_the_colours_of_their_points(image, values, background, name) -> None:
    bar = ColourBar("x", "x", "", "scalar", name, 10.0, 200.0)
    paint = Paint(background)
    paint.use_colours(bar, values)
    drawn = draw(paint, image)
    expected = colours(values, 10.0, 200.0, name, MISSING[background])[:, :3]
    for row, column in np.ndindex(drawn.shape[:2]):
        point = image.point_at(row, column)
        ground = SILENT if image.silent[0][row, column] else BACKGROUNDS
        colour = expected[point] if point >= 0 else ground[background]
        colour = colour[1] if point < 0 and ground is BACKGROUNDS else colour
        assert drawn[row, column].tolist() == list(colour)


def test_leaves_ghosts_and_selection_lie_over_the_colours_as_in_3d(image, values) -> None:
    ghosts = np.zeros(len(values), np.int8)
    ghosts[10:20] = 1
    leaf = LeafMark("leaf-00001", np.arange(5, 90), (230, 159, 0))
    paint = Paint()
    paint.use_colours(BAR, values)
    paint.use_marks(Overlay(leaves=[leaf], ghosts=ghosts, current="leaf-00001"), len(values))
    before = draw(paint, image)
    chosen = np.array([30, 31, 200])
    paint.select(image, chosen)
    drawn = draw(paint, image)
    base = colours(values, 10.0, 200.0, "viridis", MISSING["light"])[:, :3]
    lit = {image.pixel_of(int(point)) for point in chosen}
    for row, column in np.ndindex(drawn.shape[:2]):
        point = image.point_at(row, column)
        if (row, column) in lit:
            expected = mix(base[point], SELECTED_COLOUR)
        elif 10 <= point < 20:
            expected = mix(base[point], (224, 74, 16, 235))
        elif 5 <= point < 90:
            expected = np.array((230, 159, 0))
        else:
            expected = before[row, column]
        assert np.abs(drawn[row, column] - expected).max() <= 0.5
    paint.select(image, np.empty(0, np.int64))
    assert np.array_equal(draw(paint, image), before)


def test_other_limits_are_other_colours_of_the_same_picture(image, values) -> None:
    paint = Paint()
    paint.use_colours(BAR, values)
    first = draw(paint, image)
    paint.use_colours(ColourBar("x", "x", "", "scalar", "viridis", 150.0, 151.0), values)
    assert not np.array_equal(draw(paint, image), first)


def test_plain_points_fade_with_distance(image) -> None:
    drawn = draw(Paint(), image)
    shown = image.levels[0] >= 0
    far = image.layout.distance[image.levels[0][shown]]
    to_ground = np.abs(drawn[shown] - np.array(BACKGROUNDS["light"][1])).sum(axis=1)
    order = np.argsort(far)
    assert (np.diff(to_ground[order]) <= 0).all()


def test_a_coarse_level_lights_up_for_a_single_point(build, values, monkeypatch) -> None:
    monkeypatch.setattr("app.render.scan_image.image.SMALLEST", 3)
    scan, _, _ = build()
    image = make_image(lay_out(scan), scan.valid)
    paint = Paint()
    paint.use_colours(BAR, values)
    level = len(image.levels) - 1
    before = draw(paint, image, level)
    paint.select(image, np.array([0]))
    changed = (draw(paint, image, level) != before).any(axis=2)
    row, column = image.pixel_of(0)
    assert np.argwhere(changed).tolist() == [[row >> level, column >> level]]


def test_a_part_is_a_part_of_the_whole(image, values) -> None:
    paint = Paint()
    paint.use_colours(BAR, values)
    paint.select(image, np.arange(50))
    part = slice(3, 9), slice(4, 17)
    assert np.array_equal(paint.draw(image, 0, part), paint.draw(image, 0, WHOLE)[part])
