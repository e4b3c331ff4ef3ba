"""What is seen of the picture: there and back, at the cursor, never out of sight."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.render.scan_image.frame import LARGEST, TILE, Frame
from app.render.scan_image.image import make_image
from app.render.scan_image.layout import lay_out

SIZE = (300.0, 120.0)
places = st.tuples(st.floats(0, SIZE[0]), st.floats(0, SIZE[1]))


@given(places, st.floats(0.2, 8.0))
def test_what_is_under_the_cursor_stays_there(place, factor: float) -> None:
    frame = Frame(12.0, -7.0, 3.0, 2.0)
    zoomed = frame.zoom(factor, *place)
    assert zoomed.to_image(*place) == pytest.approx(frame.to_image(*place), abs=1e-9)
    assert zoomed.high == pytest.approx(frame.high * factor)


@given(places)
def test_there_and_back(place) -> None:
    frame = Frame(12.0, -7.0, 3.0, 2.0)
    assert frame.to_view(*frame.to_image(*place)) == pytest.approx(place, abs=1e-9)


def test_all_fits_in_its_proportions(build) -> None:
    layout = lay_out(build()[0])
    frame = Frame.fit(layout, SIZE)
    left, top = frame.to_view(0, 0)
    right, bottom = frame.to_view(layout.columns, layout.rows)
    assert min(left, top) == pytest.approx(0.0, abs=1e-9)
    assert (left + right, top + bottom) == pytest.approx(SIZE)
    assert frame.wide / frame.high == pytest.approx(layout.shape)


@pytest.mark.parametrize("move", [(-900.0, 0.0), (900.0, 900.0), (0.0, -900.0), (5.0, 5.0)])
@pytest.mark.parametrize("factor", [0.01, 1.0, 6.0, 1e6])
def test_nobody_loses_the_picture(build, move, factor: float) -> None:
    layout = lay_out(build()[0])
    frame = Frame.fit(layout, SIZE).zoom(factor, 30.0, 30.0).move(*move).keep(layout, SIZE)
    assert frame.high <= LARGEST * (1 + 1e-9)
    assert frame.high >= Frame.fit(layout, SIZE).high
    column, row = frame.to_image(SIZE[0] / 2, SIZE[1] / 2)
    assert 0 <= column <= layout.columns
    assert 0 <= row <= layout.rows


def test_a_level_has_about_one_pixel_per_pixel_of_the_screen(build, monkeypatch) -> None:
    monkeypatch.setattr("app.render.scan_image.image.SMALLEST", 1)
    scan, _, _ = build()
    image = make_image(lay_out(scan), scan.valid)
    sides = (40.0, 1.0, 0.9, 0.5, 0.25, 0.24)
    assert [Frame(0, 0, side, side).choose_level(image) for side in sides] == [0, 0, 0, 1, 2, 2]
    assert Frame(0, 0, 0.5, 0.5).choose_level(image, 2.0) == 0
    assert Frame(0, 0, 1e-9, 1e-9).choose_level(image) == len(image.levels) - 1


def test_the_part_covers_the_view_in_whole_tiles(build) -> None:
    scan, _, _ = build()
    image = make_image(lay_out(scan), scan.valid)
    wide = image.levels[0].shape[1]
    frame = Frame(-10.0 * wide, 5.0, 20.0, 20.0)
    down, across = frame.find_part(image, 0, SIZE)
    assert (down.start, across.start % TILE) == (0, 0)
    left, top, width, height = frame.place_part(0, (down, across))
    right, bottom = frame.to_view(*image.levels[0].shape[::-1])
    assert left <= 0 or across.start == 0
    assert left + width == pytest.approx(min(right, left + width))
    assert top + height >= min(bottom, SIZE[1])


def test_a_view_beside_the_picture_needs_nothing(build) -> None:
    scan, _, _ = build()
    image = make_image(lay_out(scan), scan.valid)
    part = Frame(900.0, 900.0, 1.0, 1.0).find_part(image, 0, SIZE)
    assert np.zeros(image.levels[0].shape)[part].size == 0
