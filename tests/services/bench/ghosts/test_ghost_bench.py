"""The bench runs, writes what it promises, and its goals can be missed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled
from app.core.progress import LiveProgress
from app.services.bench.ghosts import compare as comparing
from app.services.bench.ghosts import ours, run
from app.services.bench.ghosts.compare import Outcome, compare, thin
from app.services.bench.ghosts.goals import judge_all
from app.services.bench.ghosts.map import FALSE, MISSED, RIGHT, SIDE, classify, find_part, make_map
from app.services.bench.ghosts.measures import Curve
from app.services.bench.ghosts.plans import PLANS
from app.services.bench.ghosts.rivals import SOR_FAST
from app.services.bench.ghosts.run import PICTURES, TABLES, bench_ghosts, refuse_bench_ghosts
from app.services.bench.ghosts.scenes import make_scene
from app.services.bench.results import write_bench

NAMES = ("leaves before a wall", "crown, 4 m", "pulsed leaves, apart", "one leaf")


@pytest.fixture(scope="module")
def scene():
    return make_scene("crown, 4 m", 3, step_deg=0.15)


@pytest.fixture(scope="module")
def outcome(scene):
    return compare(scene, peers=True)[0]


@pytest.fixture
def small(monkeypatch):
    plans = [replace(plan, quick_step=0.2) for plan in PLANS if plan.name in NAMES]
    monkeypatch.setattr(run, "PLANS", plans)
    monkeypatch.setattr("app.services.bench.ghosts.scenes.PLANS", plans)
    monkeypatch.setattr(run, "warm_up", int)
    monkeypatch.setattr(comparing, "TURNS", 1)


def test_the_bench_runs_and_writes_its_tables_and_pictures(small, tmp_path):
    bench = bench_ghosts(quick=True)
    assert tuple(table.name for table in bench.tables) == TABLES
    assert tuple(bench.pictures) == PICTURES
    assert all(table.rows for table in bench.tables)
    written = write_bench(bench, tmp_path)
    assert all(path.stat().st_size > 100 for path in written)
    with pytest.raises(BadInput, match="exists"):
        refuse_bench_ghosts(tmp_path, overwrite=False)
    refuse_bench_ghosts(tmp_path, overwrite=True)


def test_the_bench_can_be_cancelled(small):
    with pytest.raises(Cancelled):
        bench_ghosts(quick=True, progress=LiveProgress(lambda *_: None, lambda: True))


def test_missing_files_of_the_other_simulator_are_refused(small, monkeypatch, tmp_path):
    monkeypatch.setattr(run, "PLANS", [])
    with pytest.raises(BadInput):
        bench_ghosts(quick=True, truth=tmp_path)


def test_full_runs_take_two_seeds_from_100_on_and_peers_on_one():
    makings = run._list_scenes(False, None)
    assert len(makings) == 2 * len(PLANS)
    assert sum(peers for _, peers in makings) == len(PLANS)
    assert min(run.SEEDS) >= 100


def test_all_take_part_and_the_best_setting_is_no_worse_than_the_usual(outcome):
    assert outcome.ours.family == ours.NAME
    assert set(SOR_FAST) <= {result.name for result in outcome.rivals}
    for result in outcome.rivals:
        assert result.best.f1 >= result.usual.f1 - 1e-12
        assert result.seconds > 0.0
    alike = [outcome.find(name).best for name in SOR_FAST]
    assert alike[0].f1 == pytest.approx(alike[1].f1)
    assert outcome.find("nobody") is None


def give(outcome: Outcome, **changes) -> Outcome:
    """The outcome with other figures of ours."""
    usual = replace(outcome.ours.usual, f1=0.97, recall=0.9, full_called=0.004)
    right = replace(outcome.corrections, share=0.6, within=0.85, worse=0.01)
    first = replace(outcome.ours, usual=replace(usual, **changes), seconds=0.001)
    return replace(outcome, results=(first, *outcome.rivals), corrections=right)


def test_goals_are_reached_and_missed_one_by_one(outcome):
    verdicts = {goal.what: goal.verdict for goal in judge_all([give(outcome)])}
    assert set(verdicts.values()) == {"reached"}
    assert len(verdicts) == 5
    for name, value in (("f1", 0.949), ("full_called", 0.0051)):
        missed = [g.what for g in judge_all([give(outcome, **{name: value})])
                  if g.verdict != "reached"]  # fmt: skip
        assert len(missed) == 1
    nothing = replace(give(outcome), corrections=replace(outcome.corrections, share=0.49,
                      within=np.nan, worse=np.nan))  # fmt: skip
    assert sum(goal.verdict != "reached" for goal in judge_all([nothing])) == 3


def test_each_group_has_its_own_limits(outcome):
    def judge(group, **changes):
        facts = replace(outcome.facts, group=group)
        goals = judge_all([replace(give(outcome, **changes), facts=facts)])
        return [goal.verdict == "reached" for goal in goals[:1]]

    assert judge("pulsed, close", f1=0.91) == [True]
    assert judge("pulsed, close", f1=0.89) == [False]
    assert judge("phase shift", f1=0.91) == [False]
    assert judge("pulsed, apart", f1=0.1, recall=0.81) == [True]
    assert judge("pulsed, apart", f1=0.99, recall=0.79) == [False]


def test_speed_is_judged_on_large_scans_against_both_trees(outcome, monkeypatch):
    monkeypatch.setattr("app.services.bench.ghosts.goals.TIMED", 10)
    goals = [goal for goal in judge_all([give(outcome)]) if "times as fast" in goal.what]
    assert len(goals) == 2
    assert goals[0].found == pytest.approx(outcome.find(SOR_FAST[0]).seconds / 0.001)


def test_a_clean_scan_is_judged_by_false_alarms_alone():
    found, called = compare(make_scene("one leaf", 3, step_deg=0.05), peers=False)
    assert called.shape == (found.facts.points,)
    assert [goal.what for goal in judge_all([found])] == ["full hits of one leaf called ghosts"]
    assert np.isnan(found.ours.best_at)
    assert np.isnan(found.ours.best.f1)


def test_our_answer_is_whole(scene):
    answer = ours.judge(scene.scan, scene.beam)
    still = ~answer.called
    np.testing.assert_array_equal(answer.ranges[still], scene.own[still])
    np.testing.assert_array_equal(np.isfinite(answer.confidence), answer.called)
    assert not (answer.corrected & still).any()
    assert np.isfinite(answer.ranges[answer.corrected]).all()


def test_a_thinned_curve_keeps_its_best_setting():
    share = np.linspace(0.001, 1.0, 5000)
    curve = Curve(-share, share, 1.0 - 0.5 * share**8, share * (1.2 - share))
    thinned = thin(curve)
    assert len(thinned.setting) <= 301
    assert thinned.f1.max() == curve.f1.max()
    short = Curve(*(np.arange(5.0) for _ in range(4)))
    assert thin(short) is short


def test_the_map_tells_right_missed_and_false_calls(scene):
    called = np.arange(len(scene)) % 3 == 0
    kind = classify(scene, called)
    assert np.sum(kind == RIGHT) == np.sum(scene.ghost & called)
    assert np.sum(kind == MISSED) == np.sum(scene.ghost & ~called)
    assert np.sum(kind == FALSE) == np.sum(scene.good & called)
    made = make_map(scene, called)
    assert made.counts == {code: int(np.sum(kind == code)) for code in (RIGHT, MISSED, FALSE)}
    grid = scene.grid
    if max(grid.rows, grid.columns) <= SIDE:  # all of it is shown
        np.testing.assert_array_equal(made.kinds[grid.row, grid.column], kind)
        np.testing.assert_array_equal(made.ranges[grid.row, grid.column], scene.own)


def test_the_part_shown_holds_most():
    shown = np.zeros((30, 50), bool)
    shown[12:17, 40:46] = True
    rows, columns = find_part(shown, 6)
    assert shown[rows, columns].sum() == 30
    assert find_part(shown, 100) == (slice(0, 30), slice(0, 50))
