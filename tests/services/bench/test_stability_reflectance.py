"""What must not change a reflectance does not, and the bench notices where it does."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from app.core.radiometry.marks import GOOD
from app.services.bench.stability import reflectances
from app.services.bench.stability.reflectances import (
    QUICK_COUNT,
    check_reflectances,
    list_cases,
    tell_case,
)
from app.services.bench.stability.signals import (
    CALIBRATIONS,
    Calibrated,
    Seen,
    judge_marks,
    tell_difference,
)

CASES = [pytest.param(case, id=f"{case.group}-{case.name}") for case in list_cases()]


@pytest.mark.parametrize("case", CASES)
def test_what_must_not_change_a_reflectance_does_not(case):
    assert tell_case(case, QUICK_COUNT)["verdict"] == "holds"


@pytest.mark.parametrize("way", CALIBRATIONS, ids=lambda way: way.name)
def test_scans_have_good_points_and_others(way):
    marks = way.see(way.make_scan(1000)).marks
    assert 0.6 < (marks == GOOD).mean() < 0.95
    assert len(np.unique(marks)) > 1


def seen(values, sigma=None, marks=None):
    values = np.array(values, float)
    given = np.zeros(len(values)) if marks is None else np.array(marks, float)
    return Seen(values, np.array(values if sigma is None else sigma, float), given)


def test_comparing():
    assert tell_difference(seen([1.0, 2.0]), seen([1.0, 2.5])) == pytest.approx(0.2)
    assert tell_difference(seen([1.0], [3.0]), seen([1.0], [2.0])) == pytest.approx(0.5)
    assert tell_difference(seen([1.0]), seen([1.0, 1.0])) == np.inf
    assert tell_difference(seen([1.0], marks=[0]), seen([1.0], marks=[1])) == np.inf
    assert tell_difference(seen([np.nan]), seen([1.0])) == np.inf
    assert tell_difference(seen([0.0, np.nan]), seen([0.0, np.nan])) == 0.0


def test_a_value_without_a_mark_is_noticed():
    assert judge_marks(seen([1.0, np.nan], marks=[0, 4])) == 0.0
    assert judge_marks(seen([np.inf], [1.0])) == np.inf
    assert judge_marks(seen([1.0], [np.nan])) == np.inf
    assert judge_marks(seen([1.0], marks=[3])) == np.inf


def test_a_warning_on_the_way_is_noticed(monkeypatch):
    real = Calibrated.see

    def warn(self, scan, points=None):
        warnings.warn("overflow", RuntimeWarning, stacklevel=1)
        return real(self, scan, points)

    case = list_cases()[0]
    monkeypatch.setattr(Calibrated, "see", warn)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert tell_case(case, 50)["verdict"].startswith("FAILS: logarithmic")


def test_a_reflectance_that_changes_with_the_place_is_noticed(monkeypatch):
    real = Calibrated.see

    def wrong(self, scan, points=None):
        found = real(self, scan, points)
        return replace(found, values=found.values + 1e-9 * scan.xyz[:, 0])

    monkeypatch.setattr(Calibrated, "see", wrong)
    case = next(case for case in list_cases() if case.group == "moved")
    assert tell_case(case, 50)["verdict"].startswith("FAILS")


def test_the_table_has_a_row_for_each_case(monkeypatch):
    monkeypatch.setattr(reflectances, "QUICK_COUNT", 50)
    table = check_reflectances(quick=True)
    assert len(table.rows) == len(CASES)
    assert {way.name for way in CALIBRATIONS} <= set(table.columns)
