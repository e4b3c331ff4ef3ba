"""Figures of hand-made cases whose answers are known, and against a plain count."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.model.parameters import Beam
from app.model.scan import Grid, Pose, Scan
from app.services.bench.ghosts.measures import judge_calls, judge_corrections, trace_curve
from app.services.bench.ghosts.reliability import judge_confidence, tabulate_reliability
from app.services.bench.ghosts.truth import Scene, cells_of, strip_truth


def make(off, **changes):
    """A scene of points at a range of 2 m with that distance off every surface."""
    off = np.asarray(off, float)
    count = len(off)
    xyz = np.column_stack((np.full(count, 2.0), np.zeros(count), np.zeros(count)))
    number = np.arange(count, dtype=np.int32)
    scan = Scan("hand", xyz, pose=Pose((0.0, 0.0, 0.0)), grid=Grid(1, count, number * 0, number))
    known = {
        "full": np.zeros(count, bool), "leaf": np.full(count, -1), "main": np.full(count, 2.0),
        "others": np.full((count, 2), np.nan), "sigma": np.full(count, 0.001),
        "exact": np.ones(count, bool),
    }  # fmt: skip
    return Scene("hand", "crown", scan, Beam(0.0015, 0.0002), 5, off, **(known | changes))


MIXED = [0.1, 0.007, 0.1, 0.004, 0.003, 0.0, 0.001, 0.002, 0.0, 0.0]
"""Three ghosts, two that count for neither, five on a surface."""


def test_points_between_count_for_neither():
    scene = make(MIXED)
    assert scene.ghost.sum() == 3
    assert scene.good.sum() == 5
    called = np.array([1, 1, 0, 1, 0, 1, 0, 0, 0, 0], bool)
    calls = judge_calls(scene, called)
    assert calls.recall == pytest.approx(2 / 3)
    assert calls.precision == pytest.approx(2 / 3)
    assert calls.f1 == pytest.approx(2 / 3)
    assert calls.good_called == pytest.approx(1 / 5)


def test_the_limits_themselves_are_ghosts_no_more_and_good_still():
    scene = make([0.006, np.nextafter(0.006, 1.0), 0.002, np.nextafter(0.002, 1.0)])
    assert scene.ghost.tolist() == [False, True, False, False]
    assert scene.good.tolist() == [False, False, True, False]


def test_missing_values_are_wrong_on_either_side():
    scene = make(MIXED, full=np.arange(10) >= 8)
    missing = np.array([1, 0, 0, 0, 0, 1, 0, 0, 0, 1], bool)
    calls = judge_calls(scene, np.array([1, 1, 1, 0, 0, 0, 0, 0, 0, 0], bool), missing)
    assert calls.recall == pytest.approx(2 / 3)
    assert calls.precision == pytest.approx(2 / 4)
    assert calls.full_called == pytest.approx(1 / 2)


def test_full_hits_are_counted_whatever_their_distance():
    scene = make(MIXED, full=np.arange(10) >= 6)
    calls = judge_calls(scene, np.arange(10) == 9)
    assert calls.full_called == pytest.approx(1 / 4)
    assert calls.f1 == 0.0


def test_without_ghosts_there_is_no_f1_but_there_are_false_alarms():
    scene = make([0.0, 0.001, 0.0, 0.0], full=np.ones(4, bool))
    calls = judge_calls(scene, np.array([True, False, False, False]))
    assert np.isnan(calls.f1)
    assert np.isnan(calls.recall)
    assert calls.full_called == 0.25
    assert trace_curve(scene, np.arange(4.0)).best == -1


@given(st.lists(st.tuples(st.sampled_from([0.0, 0.001, 0.004, 0.01, 0.5]),
                          st.sampled_from([0.0, 0.25, 0.5, 1.0, np.nan])), min_size=1))  # fmt: skip
def test_every_setting_of_the_curve_is_what_a_count_gives(points):
    off, score = (np.array(column) for column in zip(*points, strict=True))
    scene = make(off)
    curve = trace_curve(scene, score)
    assert curve.setting.tolist() == sorted(set(curve.setting), reverse=True)
    for k, setting in enumerate(curve.setting):
        calls = judge_calls(scene, score >= setting, np.isnan(score))
        if scene.ghost.any():
            assert curve.f1[k] == pytest.approx(calls.f1)
            assert curve.recall[k] == pytest.approx(calls.recall)
            assert curve.precision[k] == pytest.approx(calls.precision)
    if curve.best >= 0:
        assert curve.f1[curve.best] == curve.f1.max()


def test_a_score_of_nothing_has_an_empty_curve():
    curve = trace_curve(make([0.1, 0.0]), np.full(2, np.nan))
    assert len(curve.setting) == 0
    assert curve.best == -1


def test_ghosts_of_leaves_with_too_few_full_hits_are_not_asked_for():
    leaf = np.array([0] * 50 + [1] * 49 + [0, 1, -1])
    full = np.arange(102) < 99
    scene = make([0.0] * 99 + [0.1] * 3, leaf=leaf, full=full)
    assert scene.large[:50].all()
    assert not scene.large[50:99].any()
    assert scene.large[99:].tolist() == [True, False, False]
    found = judge_corrections(scene, np.arange(102) == 99, np.full(102, 2.0))
    assert found.share == 1.0
    none = judge_corrections(scene, np.zeros(102, bool), np.full(102, 2.0))
    assert (none.share, none.count) == (0.0, 0)
    assert np.isnan(none.within)


def test_all_corrected_points_are_judged_by_their_own_noise():
    main = np.array([2.0, 2.0, 2.01, 2.5, 2.0])
    sigma = np.array([0.001, 0.01, 0.001, 0.001, 0.001])
    scene = make([0.1, 0.1, 0.1, 0.1, 0.0], main=main, sigma=sigma, leaf=np.zeros(5, int))
    # Points stand at 2 m: the third moves nearer but not near, the fourth farther away.
    ranges = np.array([2.0019, 2.0021, 2.005, 1.9, np.nan])
    found = judge_corrections(scene, np.ones(5, bool), ranges)
    assert found.within == pytest.approx(2 / 5)
    # The first two stood on their surfaces before, and a missing range is worse than any.
    assert found.worse == pytest.approx(4 / 5)
    assert found.exact == 1.0


def test_points_whose_range_is_not_exactly_known_are_told_apart():
    exact = np.array([True, False])
    scene = make([0.1, 0.1], main=np.array([2.1, 2.1]), exact=exact)
    found = judge_corrections(scene, np.ones(2, bool), np.array([2.1, 1.9]))
    assert (found.within, found.exact_within) == (0.5, 1.0)
    assert (found.worse, found.exact_worse) == (0.5, 0.0)
    assert found.exact == 0.5


def test_a_method_gets_no_truth():
    scan = Scan(
        "s", np.ones((2, 3)), {"truth_leaf": np.zeros(2), "intensity": np.ones(2)},
        metadata={"truth_surface 0": "wall", "seed": "1"},
    )  # fmt: skip
    bare = strip_truth(scan)
    assert list(bare.attributes) == ["intensity"]
    assert list(bare.metadata) == ["seed"]
    with pytest.raises(Exception, match="no rows and columns"):
        cells_of(bare)


def test_confidence_is_held_against_what_came_true():
    scene = make([0.1] * 6)
    said = np.array([0.97, 0.96, 1.0, 0.3, 0.82, np.nan])
    # Points stand at 2 m, where they belong: whatever moves them makes it worse.
    ranges = np.array([2.0, 2.5, 2.0, np.nan, 2.0, 2.5])
    found = judge_confidence(scene, said, ranges)
    rows = tabulate_reliability([("a", found), ("b", found), ("a", found)]).rows
    assert [row["scenes"] for row in rows] == ["a"] * 3 + ["b"] * 3
    assert [(row["confidence"], row["points"], row["right_percent"]) for row in rows[:3]] == [
        ("0.2 to 0.5", 2, 0.0),
        ("0.8 to 0.85", 2, 100.0),
        ("0.95 to 1", 6, 66.7),
    ]
    assert rows[2]["said_percent"] == 97.7
