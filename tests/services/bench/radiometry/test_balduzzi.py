"""Equations 6 and 7 with the scatter of Table 2, with few seeds."""

from __future__ import annotations

import pytest

from app.services.bench.radiometry.balduzzi import (
    compare_equations,
    run_trials,
    tabulate_amplifier,
    tabulate_scatter,
)


def test_without_scatter_equations_6_and_7_agree() -> None:
    assert compare_equations() < 1e-9


def test_the_scatter_of_the_paper_comes_back() -> None:
    trials = run_trials(20)
    for row in tabulate_scatter(trials).rows:
        assert row["equation_7_ratio"] == pytest.approx(1.0, abs=0.1)
        assert row["equation_6_ratio"] > row["equation_7_ratio"]
    (row,) = tabulate_amplifier(trials).rows
    assert row["mean"] == pytest.approx(600.0, abs=0.3)
    assert row["coverage"] >= 0.75
