from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.render.lod import (
    FIRST_BLOCK,
    LARGEST_BLOCK,
    FrameBudget,
    count_blocks,
    shuffle_points,
    split_blocks,
)


def test_order_holds_every_point_once_and_is_the_same_again() -> None:
    order = shuffle_points(10_000)
    assert (np.sort(order) == np.arange(10_000)).all()
    assert (order == shuffle_points(10_000)).all()


def test_a_prefix_is_a_fair_sample() -> None:
    order = shuffle_points(100_000)
    counts = np.histogram(order[:10_000], 20, (0, 100_000))[0]
    assert counts.min() > 400
    assert counts.max() < 600


@given(st.integers(0, 40_000_000))
def test_blocks_cover_everything_in_small_steps(count: int) -> None:
    blocks = split_blocks(count)
    ends = [0, *(stop for _, stop in blocks)]
    assert [start for start, _ in blocks] == ends[:-1]
    assert ends[-1] == count
    sizes = np.diff(ends)
    assert (sizes > 0).all()
    assert (sizes <= LARGEST_BLOCK).all()
    assert count < FIRST_BLOCK or sizes[0] == FIRST_BLOCK


@given(st.integers(1, 5_000_000), st.floats(0, 1e7), st.integers(0, 30))
def test_counted_blocks_fit_or_are_the_smallest_step(
    points: int, allowed: float, drawn: int
) -> None:
    blocks = split_blocks(points)
    more = count_blocks(blocks, allowed, drawn)
    if drawn >= len(blocks):
        assert more == 0
        return
    size = blocks[drawn + more - 1][1] - blocks[drawn][0]
    assert more == 1 or size <= allowed
    if drawn + more < len(blocks):
        assert blocks[drawn + more][1] - blocks[drawn][0] > allowed


@pytest.mark.parametrize("rate", [3e5, 2e6, 5e7])
def test_budget_learns_the_speed_of_the_machine(rate: float) -> None:
    budget = FrameBudget(target=0.1)
    for _ in range(30):
        points = max(budget.points, FIRST_BLOCK)
        budget.record(points, points / rate)
    assert budget.points == pytest.approx(0.1 * rate, rel=0.01)


def test_budget_ignores_frames_that_tell_nothing() -> None:
    budget = FrameBudget()
    before = budget.rate
    budget.record(10, 0.5)
    budget.record(1_000_000, 0.0)
    assert budget.rate == before
