"""The must of SALCA's calibration with few seeds: coverage, budget, singular value, staged fit."""

from __future__ import annotations

import numpy as np
import pytest

from app.services.bench.radiometry.hancock import (
    NOISES,
    PAPER_RMSE,
    TABLE_III,
    Trial,
    fit_panels,
    make_panels,
    name_noise,
    run_trials,
    tabulate_coverage,
    tabulate_forms,
    tabulate_reflectance,
    tabulate_singular,
)

SEEDS = 20


@pytest.fixture(scope="module")
def trials() -> dict[tuple[int, object], list[Trial]]:
    return run_trials(SEEDS, noises=NOISES[1:])  # type: ignore[return-value]


def test_joint_intervals_hold_the_truth_and_staged_ones_do_not(trials) -> None:  # type: ignore[no-untyped-def]
    table = tabulate_coverage(trials)
    *rows, pooled = table.rows
    assert len(rows) == 12
    assert 0.90 <= pooled["joint_coverage"] <= 0.99
    assert min(row["joint_coverage"] for row in rows) >= 0.75
    last = [row["staged_coverage"] for row in rows if row["parameter"] == "k3"]
    assert max(last) < 0.75


def test_the_budget_tells_the_error_of_other_targets(trials) -> None:  # type: ignore[no-untyped-def]
    for row in tabulate_reflectance(trials).rows:
        assert row["ratio"] == pytest.approx(1.0, abs=0.2)
        assert row["paper_rmse_percent"] == PAPER_RMSE[row["wavelength_nm"]]


def test_the_singular_value_is_zero_only_without_a_fixed_power() -> None:
    for row in tabulate_singular().rows:
        assert (row["smallest"] < 1e-12) == (row["powers"] == "none fixed")
        assert row["second_smallest"] > 1e-3


def test_both_forms_are_shown_with_their_fit() -> None:
    table = tabulate_forms()
    assert [row["form"] for row in table.rows] == ["outer", "inner"] * 4
    assert all(row["chi_square"] == pytest.approx(160, rel=0.15) for row in table.rows)


def test_the_panels_are_as_ordered() -> None:
    table = make_panels(1545, NOISES[0], np.random.default_rng(0))
    assert len(table) == 15 * 12
    assert (table.distance.min(), table.distance.max()) == (2.0, 60.0)
    found = fit_panels(table)
    assert found.reference_range == 8.0
    assert found.fit.powers()[found.reference_scan] == 1.0
    assert found.fit.found.natural()[3] == pytest.approx(TABLE_III[1545]["m"], rel=0.03)
    assert name_noise(NOISES[1]) == "1 % + 1 DN"
