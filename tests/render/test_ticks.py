from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.render.ticks import label_ticks, round_ticks


@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (0, 90, ["0", "20", "40", "60", "80"]),
        (-30, 30, ["−30", "−20", "−10", "0", "10", "20", "30"]),
        (0, 1, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (0, 0.1, ["0.00", "0.02", "0.04", "0.06", "0.08", "0.10"]),
    ],
)
def test_numbers_are_the_ones_that_people_write(low: float, high: float, labels: list[str]) -> None:
    assert label_ticks(round_ticks(low, high, 7 if low < 0 else 6)) == labels


@given(st.floats(-1e6, 1e6), st.floats(1e-4, 1e6), st.integers(2, 12))
def test_ticks_lie_inside_ascend_and_are_few(low: float, span: float, most: int) -> None:
    ticks = round_ticks(low, low + span, most)
    assert 1 <= len(ticks) <= most
    slack = 1e-6 * span
    assert all(low - slack <= tick <= low + span + slack for tick in ticks)
    assert ticks == sorted(set(ticks))


@pytest.mark.parametrize("limits", [(1, 1), (2, 1), (0, math.nan), (0, math.inf)])
def test_no_range_has_no_ticks(limits: tuple[float, float]) -> None:
    assert round_ticks(*limits) == []
    assert label_ticks([]) == []


@given(st.floats(-1e4, 1e4), st.floats(1e-2, 1e4))
def test_labels_tell_ticks_apart(low: float, span: float) -> None:
    labels = label_ticks(round_ticks(low, low + span))
    assert len(set(labels)) == len(labels)
