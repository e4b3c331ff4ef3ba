"""The bench of wrinkles: its measures on known cases, and one quick run."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.services.bench.radiometry.goals import MISSED
from app.services.bench.results import write_bench
from app.services.bench.stability.inversions import Case, list_cases, tell_case
from app.services.bench.wrinkles.goals import judge_goals, tabulate_goals
from app.services.bench.wrinkles.run import TABLES, bench_wrinkles, refuse_bench_wrinkles
from app.services.bench.wrinkles.scenes import read_other
from app.services.bench.wrinkles.separation import area_under_curve

CASES = [pytest.param(case, id=f"{case.group}-{case.name}") for case in list_cases()]


@pytest.mark.parametrize("case", CASES)
def test_inversions_at_the_ends_of_their_domain(case):
    assert tell_case(case)["verdict"] == "holds"


def test_what_is_wrong_is_noticed():
    wrong = Case("x", "too far", 0.1, lambda _: 0.2)
    missing = Case("x", "nothing", 0.1, lambda _: np.nan)
    accepted = Case("x", "should be refused", 0.1, lambda _: 0.0, refused=True)
    for case in (wrong, missing, accepted):
        assert tell_case(case)["verdict"].startswith("FAILS")


def test_area_under_curve():
    low, high = np.array([1.0, 2.0]), np.array([2.0, 3.0, 4.0])
    wins = np.mean((high[:, None] > low) + 0.5 * (high[:, None] == low))
    assert area_under_curve(low, high) == pytest.approx(wins)
    assert area_under_curve(high, high) == 0.5
    assert np.isnan(area_under_curve(np.empty(0), high))


def test_a_missed_goal_is_said():
    row = {"scene": "s", "kind": "all", "points": "all points of leaves"}
    tables = {
        "wrinkles_known": [{**row, "right": 0.94, "valid_15_to_60": 0.81}],
        "wrinkles_species": [{"scene": "s", "omega_found_deg": "all", "covered": 0.74}],
        "wrinkles_separation": [{"scene": "s", "auc_flat": float("nan")}],
    }
    goals = judge_goals(tables)
    assert [goal.verdict for goal in goals] == [MISSED, "reached", MISSED, MISSED]
    assert MISSED not in [row["verdict"] for row in tabulate_goals(goals, quick=True).rows]


def test_one_quick_run(tmp_path):
    found = bench_wrinkles(quick=True)
    assert tuple(table.name for table in found.tables) == TABLES
    known = found.tables[1].rows[0]
    assert known["right"] > 0.9
    assert all(table.rows for table in found.tables)
    write_bench(found, tmp_path / "out")
    with pytest.raises(BadInput, match="exists"):
        refuse_bench_wrinkles(tmp_path / "out", None, overwrite=False)


def test_other_files_that_are_missing(tmp_path):
    with pytest.raises(BadInput, match="phase_shift"):
        read_other(tmp_path, "phase_shift")


@pytest.mark.data
def test_leaves_of_the_other_simulator(shared_data):
    leaves = read_other(shared_data / "truth_scenes", "phase_shift")
    assert len(leaves) > 50
    assert {leaf.kind for leaf in leaves} == {"flat", "bent", "wrinkled"}
    heights = [leaf.sheen["f"] for leaf in leaves]
    assert np.median(heights) == pytest.approx(0.27, rel=0.05)
