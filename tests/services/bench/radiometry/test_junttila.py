"""Amplifiers with drift, unsure panels and a saturated one, with few seeds."""

from __future__ import annotations

import pytest

from app.services.bench.radiometry.junttila import SCANS, run_trials, tabulate


def test_response_drift_and_reflectance_come_back() -> None:
    for row in tabulate(run_trials(40)).rows:
        assert row["saturated_rows_left_out"] == pytest.approx(SCANS, abs=0.5)
        assert row["first_coverage"] >= 0.8
        assert row["second_coverage"] >= 0.8
        assert row["power_coverage"] >= 0.9
        assert row["ratio"] == pytest.approx(1.0, abs=0.25)
