from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from app.model.scene import ColourBar
from app.render.palettes import VERDICT, colour_table
from widgets.viewport.colour_bar import ColourBarWidget
from widgets.viewport.histogram import count_values

BAR = ColourBar("range", "Range", "m", "scalar", "cividis", 2.0, 8.0)


@pytest.fixture
def bar(qtbot: QtBot) -> ColourBarWidget:
    widget = ColourBarWidget()
    qtbot.addWidget(widget)
    widget.show_bar(BAR, np.linspace(0, 10, 5000))
    widget.resize(widget.sizeHint())
    return widget


def centre(bar: ColourBarWidget, value: float) -> QPoint:
    return QPoint(round(bar.scale_rect().center().x()), round(bar.position_of(value)))


@pytest.mark.parametrize(("handle", "to"), [("high", 6.0), ("low", 4.0)])
def test_dragging_a_handle_moves_its_limit(bar: ColourBarWidget, handle: str, to: float) -> None:
    seen: list[tuple[float, float, bool]] = []
    bar.limits_changed.connect(lambda *limits: seen.append(limits))
    start = 8.0 if handle == "high" else 2.0
    QTest.mousePress(bar, Qt.MouseButton.LeftButton, pos=centre(bar, start))
    for share in (0.3, 0.7, 1.0):
        QTest.mouseMove(bar, centre(bar, start + share * (to - start)))
    QTest.mouseRelease(bar, Qt.MouseButton.LeftButton, pos=centre(bar, to))
    low, high, finished = seen[-1]
    assert finished
    assert not any(done for _, _, done in seen[:-1])
    assert len(seen) == 4
    pixel = 10 / bar.scale_rect().height()
    moved, kept = (high, low) if handle == "high" else (low, high)
    assert moved == pytest.approx(to, abs=pixel)
    assert kept == (2.0 if handle == "high" else 8.0)


def test_handles_never_cross(bar: ColourBarWidget) -> None:
    QTest.mousePress(bar, Qt.MouseButton.LeftButton, pos=centre(bar, 8.0))
    QTest.mouseRelease(bar, Qt.MouseButton.LeftButton, pos=centre(bar, 0.5))
    low, high = bar.limits
    assert low == 2.0
    assert 2.0 < high < 2.2


def test_keys_move_the_limits(bar: ColourBarWidget) -> None:
    QTest.keyClick(bar, Qt.Key.Key_Down)
    QTest.keyClick(bar, Qt.Key.Key_Up, Qt.KeyboardModifier.ShiftModifier)
    low, high = bar.limits
    assert low == pytest.approx(2.1, abs=0.01)
    assert high == pytest.approx(7.9, abs=0.01)


def test_the_strip_shows_the_colours_of_its_values(bar: ColourBarWidget) -> None:
    image = bar.grab().toImage()
    scale = image.devicePixelRatio()
    for value, row in ((9.5, 255), (5.0, 128), (0.5, 0)):
        at = centre(bar, value)
        colour = image.pixelColor(round(at.x() * scale), round(at.y() * scale))
        found = np.array(colour.getRgb()[:3])
        assert np.abs(found - colour_table("cividis")[row, :3].astype(int)).max() <= 6


def test_flags_and_classes_have_no_handles(bar: ColourBarWidget) -> None:
    for kind, name in (
        ("flag", "flag"),
        ("class", "leaves"),
        ("verdict", "verdict"),
        ("mark", "marks"),
    ):
        bar.show_bar(ColourBar("f", "F", "", kind, name, 0.0, 1.0), np.array([0.0, 1.0]))
        seen: list[object] = []
        bar.limits_changed.connect(lambda *limits, seen=seen: seen.append(limits))
        QTest.mouseClick(bar, Qt.MouseButton.LeftButton, pos=QPoint(40, 100))
        assert seen == []
        assert bar.grab().toImage().width() > 0


def test_no_field_hides_the_bar(bar: ColourBarWidget) -> None:
    bar.show_bar(None, None)
    assert bar.isHidden()


def test_histogram_counts_what_is_there() -> None:
    values = np.concatenate((np.full(900, 1.01), np.full(100, 3.01), [np.nan, np.inf]))
    histogram = count_values(values, 0.0, 4.0)
    assert (histogram.low, histogram.high) == (0.0, 4.0)
    middles = (histogram.edges[1:] + histogram.edges[:-1]) / 2
    heights = histogram.heights
    assert heights[np.abs(middles - 1.01).argmin()] == 1.0
    assert heights.sum() == pytest.approx(1 + np.sqrt(100 / 900))


def test_histogram_of_nothing_is_empty() -> None:
    assert len(count_values(np.full(5, np.nan), 0.0, 1.0).heights) == 0


def test_a_verdict_shows_its_three_answers(bar: ColourBarWidget) -> None:
    bar.show_bar(ColourBar("f", "F", "", "verdict", "verdict", 0.0, 2.0), np.array([0.0, 1.0, 2.0]))
    image = bar.grab().toImage()
    shown = {
        image.pixelColor(x, y).name() for x in range(image.width()) for y in range(image.height())
    }
    assert set(VERDICT) <= shown


def test_a_narrow_bar_has_no_histogram_but_whole_numbers(bar: ColourBarWidget) -> None:
    wide = bar.width()
    left = bar.scale_rect().left()
    bar.set_narrow(True)
    bar.resize(bar.sizeHint())
    assert bar.width() < 0.6 * wide
    assert bar.scale_rect().left() < 0.3 * left
    text = bar.fontMetrics().horizontalAdvance("10.0")
    assert bar.scale_rect().right() + 0.9 * bar.fontMetrics().height() + text < bar.width()
    QTest.mousePress(bar, Qt.MouseButton.LeftButton, pos=centre(bar, 8.0))
    QTest.mouseRelease(bar, Qt.MouseButton.LeftButton, pos=centre(bar, 6.0))
    assert bar.limits[1] == pytest.approx(6.0, abs=0.05)
