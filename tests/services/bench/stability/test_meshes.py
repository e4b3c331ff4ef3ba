"""Areas that must not change, and refusals."""

from __future__ import annotations

import pytest

from app.services.bench.stability.meshes import (
    check_meshes,
    judge_case,
    list_cases,
    make_square,
    measure,
    true_area,
)


def test_all_hold():
    assert {row["verdict"] for row in check_meshes().rows} == {"right", "refused"}


def test_closed_form():
    assert measure(*make_square()) == pytest.approx(true_area(), rel=1e-3)


def test_a_wrong_area_fails():
    row = judge_case(list_cases()[0], 1.0, lambda *_: 2.0 * true_area())
    assert row["verdict"] == "FAILS"
