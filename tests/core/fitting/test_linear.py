"""Stacked, bounded least squares against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from app.core.fitting.covariance import compute_covariance, take_deviations
from app.core.fitting.linear import solve_bounded, solve_free

FREE = np.full(4, np.inf)


def test_stack_without_bounds() -> None:
    rng = np.random.default_rng(1)
    columns, target = rng.normal(size=(6, 4, 30)), rng.normal(size=30)
    found, residual = solve_bounded(columns, target, -FREE, FREE)
    for stack, coefficients, rest in zip(columns, found, residual, strict=True):
        expected = np.linalg.lstsq(stack.T, target, rcond=None)[0]
        np.testing.assert_allclose(coefficients, expected, rtol=1e-10)
        np.testing.assert_allclose(rest, target - expected @ stack, atol=1e-12)


@pytest.mark.parametrize("upper", [np.inf, 0.3])
def test_two_bounded_columns(upper: float) -> None:
    rng = np.random.default_rng(2)
    columns, target = rng.normal(size=(200, 2, 12)), rng.normal(size=(200, 12))
    found, residual = solve_bounded(columns, target, np.zeros(2), np.full(2, upper))
    for stack, goal, coefficients, rest in zip(columns, target, found, residual, strict=True):
        expected = lsq_linear(stack.T, goal, (0, upper), tol=1e-14)
        assert rest @ rest == pytest.approx(2 * expected.cost, rel=1e-9)
        assert ((coefficients >= 0) & (coefficients <= upper)).all()
        np.testing.assert_allclose(goal - coefficients @ stack, rest, atol=1e-12)


def test_dependent_and_empty_columns_take_no_part() -> None:
    one = np.linspace(1, 2, 9)
    found, residual = solve_free(np.stack((one, 3 * one, np.zeros(9))), 5 * one)
    np.testing.assert_allclose(found, [5, 0, 0], atol=1e-12)
    np.testing.assert_allclose(residual, 0, atol=1e-12)


def test_undetermined_directions_have_no_deviation() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 50))
    sd = take_deviations(compute_covariance(np.column_stack((a, b, b, np.zeros(50))), 0.5))
    assert np.isnan(sd).tolist() == [False, True, True, True]
    alone = np.column_stack((a, b))
    assert sd[0] == pytest.approx(0.5 * np.sqrt(np.linalg.inv(alone.T @ alone)[0, 0]))
