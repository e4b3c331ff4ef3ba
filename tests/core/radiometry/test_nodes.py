"""Where the pieces of a range curve meet."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.radiometry.nodes import choose_nodes, find_ranges, place_reference, take_nodes
from app.core.radiometry.range_curve import PolynomialCurve

AWAY = np.repeat(np.arange(1.0, 14.0), 6)


def measure(values: np.ndarray):  # type: ignore[no-untyped-def,type-arg]
    def misfit(curve: PolynomialCurve) -> float:
        columns = curve.shares(AWAY).T
        best = np.linalg.lstsq(columns, values, rcond=None)[0]
        return float(np.sum((columns @ best - values) ** 2) / np.sum((values - values.mean()) ** 2))

    return misfit


def test_ranges_that_are_nearly_the_same_are_one() -> None:
    found = find_ranges(np.array([8.01, 2.0, 8.0, 2.005, 20.0]))
    assert found == pytest.approx([2.0, 8.005, 20.0])


def test_the_reference_takes_the_place_of_its_neighbour() -> None:
    assert place_reference(np.array([1.0, 3.6, 10.0]), 3.56).tolist() == [1.0, 3.56, 10.0]
    assert place_reference(np.array([1.0, 3.6, 10.0]), 10.0).tolist() == [1.0, 3.6, 10.0]
    with pytest.raises(WrongUse, match="outside the panels' 1 to 10 m"):
        place_reference(np.array([1.0, 3.6, 10.0]), 11.0)


def test_a_straight_line_needs_no_inner_node_but_the_reference() -> None:
    random = np.random.default_rng(1)
    values = 5 - 2 * AWAY + 0.1 * random.standard_normal(len(AWAY))
    nodes = choose_nodes(AWAY, 7.0, "additive", measure(values))
    assert nodes.ranges == (1.0, 7.0, 13.0)
    assert nodes.order == 1


def test_a_bent_curve_is_followed() -> None:
    random = np.random.default_rng(1)
    values = 300 * np.sin(AWAY / 2) + 1.0 * random.standard_normal(len(AWAY))
    nodes = choose_nodes(AWAY, 7.0, "additive", measure(values))
    assert len(nodes.ranges) >= 7
    assert {1.0, 7.0, 13.0} <= set(nodes.ranges)


def test_breaks_by_hand_and_too_few_rows() -> None:
    assert take_nodes((4.0, 9.0), AWAY, 7.0).ranges == (1.0, 4.0, 7.0, 9.0, 13.0)
    with pytest.raises(WrongUse, match="break at 20 m"):
        take_nodes((20.0,), AWAY, 7.0)
    with pytest.raises(BadInput, match="3 rows cannot determine"):
        choose_nodes(np.array([1.0, 2.0, 3.0]), 2.0, "additive", lambda _: 1.0)
