"""Who takes part is judged alike: errors, ratios, the front, the goals, what is missing."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from app.services.bench.incidence import goals, leaves, peers
from app.services.bench.incidence.goals import Goal, judge_bound, judge_coverage, judge_rivals
from app.services.bench.incidence.memory import measure_memory
from app.services.bench.incidence.peers import find_cloudcompare, fit_lists
from app.services.bench.incidence.plan import Field, count_neighbours, run_all
from app.services.bench.incidence.reference import compare_with_tree, fit_balls
from app.services.bench.incidence.rivals import Estimate, Load, Rival, our_rival, single_rival
from app.services.bench.incidence.run import tell_peers
from app.services.bench.incidence.scenes import USUAL, make_plane
from app.services.bench.incidence.table import find_front, tell_kinds, tell_load


@pytest.fixture(scope="module")
def load():
    truth = make_plane(40.0, 70)
    made = Load(truth, USUAL, truth.add_noise(USUAL))
    our_rival(made, "ball", 0.004).run()  # compiled before any clock runs
    return made


def invent(load, program, method, radius, seconds, off, missing=0):
    """A rival that is wrong by `off` degrees everywhere, in a stated time."""

    def estimate(load):
        truth = load.truth
        beams = truth.xyz / np.linalg.norm(truth.xyz, axis=1)[:, None]
        side = np.cross(beams, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side, axis=1)[:, None]
        omega = np.deg2rad(truth.omega + off)[:, None]
        normals = -np.cos(omega) * beams + np.sin(omega) * side
        normals[:missing] = np.nan
        return Estimate(normals, radius, 0.25, seconds)

    rival = Rival(method, program, radius, estimate, load)
    rival.run()
    return rival


def test_errors_ratios_and_front(load):
    total = len(load.xyz)
    rivals = [
        invent(load, "Leafscope", "adaptive", 0.004, 1.0, 1.0),
        invent(load, "Leafscope", "ball, grid", 0.004, 3.0, 2.0, missing=total // 5),
        invent(load, "Open3D", "radius search", 0.004, 50.0, 4.0),
        invent(load, "Open3D", "radius search", 0.006, 100.0, 3.0),
    ]
    ours, ball, theirs, _ = tell_load(rivals)
    assert ours["seconds"] == pytest.approx(1.0, rel=0.1)
    assert ours["preparing_s"] == 0.25
    assert ours["times_faster"] == pytest.approx(50.0, rel=0.1)
    assert ours["median_deg"] == pytest.approx(1.0, rel=1e-3)
    assert ours["median_ratio"] == pytest.approx(0.25, rel=1e-2)
    assert ours["median_ratio_to_best"] == pytest.approx(1 / 3, rel=1e-2)
    assert ball["p90_deg"] == 90.0
    assert ball["undefined"] == pytest.approx(0.2, abs=1e-3)
    assert theirs["times_faster"] == 1.0
    assert [row["on_pareto"] for row in (ours, ball, theirs)] == [True, False, False]


def test_without_open3d_there_is_no_ratio(load):
    (row,) = tell_load([invent(load, "Leafscope", "adaptive", 0.004, 1.0, 1.0)])
    assert np.isnan(row["times_faster"])
    assert np.isnan(row["median_ratio_to_best"])


def test_one_radius_has_no_best(load):
    row = tell_load([invent(load, "Open3D", "radius search", 0.004, 1.0, 1.0)])[0]
    assert row["median_ratio"] == 1.0
    assert np.isnan(row["median_ratio_to_best"])


def test_front():
    assert find_front([(1, 3), (2, 2), (2, 3), (3, 1), (3, 1)]) == [True, True, False, True, True]


def test_kinds_are_told_apart(load):
    rows = tell_kinds([invent(load, "Leafscope", "adaptive", 0.004, 1.0, 1.5)])
    assert [row["leaves"] for row in rows] == ["flat"]
    assert rows[0]["median_deg"] == pytest.approx(1.5, rel=1e-3)


def test_verdicts():
    assert Goal("s", "n", "w", 26.0, 25.0, at_least=True).verdict == "reached"
    assert Goal("s", "n", "w", 24.0, 25.0, at_least=True).verdict == "NOT REACHED"
    assert Goal("s", "n", "w", 0.5, 0.5).verdict == "reached"
    assert Goal("s", "n", "w", 0.51, 0.5).verdict == "NOT REACHED"
    assert Goal("s", "n", "w", float("nan"), 0.5).verdict == "not measured"
    assert Goal("s", "n", "w", 26.0, 25.0, at_least=True).as_row()["limit"] == "≥ 25"


def make_row(scene, method, program="Leafscope", **values):
    base = {
        "scene": scene, "noise": "white", "sigma_mm": 0.7, "method": method, "program": program,
        "radius_mm": 4.0, "times_faster": 30.0, "median_ratio": 0.4, "p90_ratio": 0.7,
        "median_ratio_to_best": 0.9, "p90_ratio_to_best": 1.2,
    }  # fmt: skip
    return base | values


def test_goals_of_the_main_table():
    rows = [
        make_row(scene, method)
        for scene in ("clean", "hard")
        for method in ("adaptive", "ball, grid", "ball, voxels")
    ]
    found = {(g.scene, g.what): g.verdict for g in judge_rivals(rows, 0.004)}
    assert found["clean", goals.WORDS["p90_ratio"]] == "NOT REACHED"
    assert found["hard", goals.WORDS["p90_ratio"]] == "reached"
    assert found["hard", goals.BEST["p90_ratio_to_best"]] == "NOT REACHED"
    assert ("clean", goals.BEST["p90_ratio_to_best"]) not in found
    assert len(found) == 12


def test_goals_of_coverage_and_bound():
    base = {
        "scene": "hard", "noise": "white", "sigma_mm": 0.7, "leaves": "flat",
        "where": "away from the pole", "points": "all", "within 1 σ": 0.62,
    }  # fmt: skip
    others = [
        base | {"noise": "correlated"}, base | {"leaves": "wrinkled"},
        base | {"where": "near the pole"}, base | {"points": "undisturbed"},
    ]  # fmt: skip
    (goal,) = judge_coverage([base, *others])
    assert goal.verdict == "NOT REACHED"
    (goal,) = judge_coverage([base | {"within 1 σ": 0.66}])
    assert goal.verdict == "reached"
    assert judge_bound([]) == []


def test_missing_programs_are_listed():
    table = tell_peers((peers.Peer("Open3D", ""), peers.Peer("SciPy", "installed")))
    states = {row["program"]: row["state"] for row in table.rows}
    assert states == {"Open3D": "missing", "SciPy": "took part"}
    assert "--peers" in tell_peers(()).rows[0]["state"]


def test_ours_and_the_simple_way_agree(load):
    ball, simple = our_rival(load, "ball", 0.004), peers.scipy_rival(load, 0.004)
    ball.run()
    simple.run()
    compared = simple.judged & np.isfinite(ball.omega) & (ball.width == np.float32(0.004))
    off = np.abs(ball.omega - simple.omega)[compared]
    assert compared.sum() > 1000
    assert np.median(off) < 1e-4
    assert simple.median_seconds > 0


def test_lists_are_fitted():
    square = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1], [9, 9, 9]], float)
    near = [[0, 1, 2, 3], [0, 1]]
    normals = fit_lists(square, np.array([0, 1]), near)
    assert np.abs(normals[0]) == pytest.approx([0, 0, 1])
    assert np.isnan(normals[1]).all()


def test_single_precision_is_hardly_worse(load):
    double, single = our_rival(load, "ball", 0.006), single_rival(load, "ball", 0.006)
    double.run()
    single.run()
    assert "float32" in single.method
    assert np.median(single.errors()) == pytest.approx(np.median(double.errors()), rel=1e-2)


@pytest.mark.skipif(not find_cloudcompare(), reason="CloudCompare is not installed")
def test_cloudcompare_takes_part(load):
    rival = peers.cloudcompare_rival(load, 0.006, find_cloudcompare())
    rival.run()
    assert np.median(rival.errors()) < 5.0


@pytest.mark.skipif(not find_spec("open3d"), reason="Open3D is not installed")
@pytest.mark.parametrize("search", ["radius", "knn", "hybrid"])
def test_open3d_takes_part(load, search):
    rival = peers.open3d_rival(load, 0.006, search, 30)
    rival.run()
    assert np.median(rival.errors()) < 5.0


def test_equal_to_a_tree(load):
    equal = compare_with_tree(load.truth, load.xyz, 0.004, grid=True)
    assert equal.compared > 0.7 * equal.asked
    assert equal.worst < 1e-6
    normals, count = fit_balls(load.xyz, np.array([2450]), np.array([1e-6]))
    assert count.tolist() == [1]
    assert np.isnan(normals).all()


def test_all_run_in_the_order_of_the_plan(load):
    field = Field(0.004, (), quick=True)
    rivals = run_all(load, field)
    names = [rival.name for rival in rivals]
    assert len(set(names)) == len(names)
    assert {"Leafscope adaptive 4", "Leafscope window 6", "Leafscope ball, voxels 4"} <= set(names)
    assert all(len(rival.seconds) == 1 and np.isnan(rival.spread) for rival in rivals)
    assert count_neighbours(load, 0.006) > count_neighbours(load, 0.003)


def test_few_leaves_are_chosen():
    truth = make_plane(10.0, 60)
    truth.leaf[:] = truth.grid.column
    points = leaves.choose_leaves(truth)
    assert len(np.unique(truth.leaf[points])) == leaves.LEAVES
    assert len(points) == 60 * leaves.LEAVES


def test_memory_is_measured_in_a_process_of_its_own(load):
    truth = make_plane(10.0, 300)
    found = measure_memory(truth, truth.xyz, 0.004)
    # Normals alone are 24 bytes a point.
    assert 24 < found < 2000
