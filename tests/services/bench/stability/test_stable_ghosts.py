"""Verdicts on ghosts at the ends of what they are made for, and a judge that can say no."""

from __future__ import annotations

import numpy as np

from app.core.errors import BadInput
from app.services.bench.stability.ghosts import (
    check_ghosts,
    judge,
    judge_case,
    list_cases,
    make_scan,
)


def test_every_case_is_right_or_refused():
    rows = check_ghosts().rows
    assert [row for row in rows if row["verdict"] not in ("right", "refused")] == []
    assert sum(row["verdict"] == "refused" for row in rows) == 2
    assert make_scan().wanted.sum() > 300


def test_the_judge_finds_faults():
    scan = make_scan()
    cases = {case.name: case for case in list_cases()}

    def turns_some(given):
        found = judge(given)
        found[:100] ^= True
        return found

    def refuses(given):
        raise BadInput("no")

    def fails(given):
        raise ArithmeticError("nowhere")

    assert judge_case(cases["points in another order"], scan, turns_some)["verdict"] == "FAILS"
    assert judge_case(cases["unchanged"], scan, refuses)["verdict"] == "FAILS"
    assert judge_case(cases["unchanged"], scan, fails)["words"] == "nowhere"
    accepts = judge_case(cases["rows beyond the grid"], scan, lambda given: given.wanted)
    assert accepts["verdict"] == "FAILS"
    assert np.isnan(accepts["limit"])
