"""Parallel areas of an ellipse against distances that are measured, and known limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.special import ellipe

from app.core.ellipse import parallel_area

HALF = st.floats(1e-3, 10.0)


def measured_area(a: float, b: float, within: float, cells: int = 700) -> float:
    """Count cells by their distance from a border of many points."""
    reach = max(a, b) + max(-within, 0.0) + 0.05
    line = np.linspace(-reach, reach, cells)
    x, y = (side.ravel() for side in np.meshgrid(line, line))
    turn = np.linspace(0.0, 2 * np.pi, 4001)
    border = np.column_stack((a * np.cos(turn), b * np.sin(turn)))
    away, _ = cKDTree(border).query(np.column_stack((x, y)))
    signed = np.where((x / a) ** 2 + (y / b) ** 2 < 1.0, away, -away)
    return float((signed >= within).sum() * (line[1] - line[0]) ** 2)


@pytest.mark.parametrize(
    ("a", "b", "within"),
    [(2, 1, 0.3), (2, 1, 0.7), (1, 2, 0.9), (3, 0.5, 0.3), (2, 1, -0.4), (3, 0.05, -0.3)],
)
def test_it_is_the_area_that_is_measured(a: float, b: float, within: float) -> None:
    # Counting cells errs by about the border's length over their number.
    assert parallel_area(a, b, within) == pytest.approx(measured_area(a, b, within), abs=0.02)


def test_a_circle_stays_one() -> None:
    within = np.array([-2.0, -0.5, 0.0, 0.3, 0.999])
    assert parallel_area(1.0, 1.0, within) == pytest.approx(np.pi * (1.0 - within) ** 2)


@given(HALF, HALF, st.floats(0.0, 5.0))
def test_outside_it_is_steiners_formula(a: float, b: float, out: float) -> None:
    border = 4.0 * max(a, b) * ellipe(1.0 - (min(a, b) / max(a, b)) ** 2)
    steiner = np.pi * a * b + border * out + np.pi * out**2
    assert parallel_area(a, b, -out) == pytest.approx(steiner, rel=1e-9)


@given(HALF, HALF, st.floats(-1.0, 1.5), st.floats(0.0, 0.5))
def test_deeper_places_are_fewer_and_scale_changes_nothing(
    a: float, b: float, share: float, more: float
) -> None:
    t = share * min(a, b)
    here = float(parallel_area(a, b, t))
    assert 0.0 <= parallel_area(a, b, t + more) <= here * (1 + 1e-9) + 1e-12
    assert parallel_area(b, a, t) == pytest.approx(here, rel=1e-12)
    assert parallel_area(1e9 * a, 1e9 * b, 1e9 * t) == pytest.approx(1e18 * here, rel=1e-9)


def test_limits_and_shapes() -> None:
    assert parallel_area(2.0, 1.0, 1.0) == 0.0
    assert parallel_area(2.0, 1.0, 5.0) == 0.0
    assert parallel_area(2.0, 0.0, -0.5) == pytest.approx(2 * 4 * 0.5 + np.pi / 4)
    assert parallel_area(np.ones((2, 1)), 1.0, np.zeros(3)).shape == (2, 3)
