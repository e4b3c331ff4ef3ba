"""Figures of areas and segments, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from app.services.bench.area.goals import judge
from app.services.bench.area.measures import Measured, match_segments, summarise
from app.services.bench.area.rivals import delaunay_area, hull_area, keep_inliers


def test_matches_by_hand():
    leaf = np.repeat([0, 1, 2, -1], [100, 100, 20, 60])
    label = np.concatenate(
        [np.repeat([0, 1], [60, 40]), np.full(100, 2), np.full(20, 3), np.full(60, 4)]
    )
    match = match_segments(label, leaf, np.ones(280, bool), np.ones(280, bool))
    # Leaf 0 by segment 0 (60 %), leaf 1 whole; leaf 2 is too small; 1 and 4 are no leaves.
    assert (match.found, match.missed, match.false) == (2, 0, 2)
    assert match.f1 == pytest.approx(4 / 6)
    assert match.segment.tolist() == [0, 2, 3]


def test_nothing_found():
    match = match_segments(
        np.full(100, -1), np.zeros(100, int), np.ones(100, bool), np.ones(100, bool)
    )
    assert (match.found, match.missed, match.f1) == (0, 1, 0.0)


def test_summary():
    told = summarise([Measured("flat", e, e < 0.02, 0.03) for e in (-0.01, 0.01, 0.03)])
    assert told["median"] == pytest.approx(1.0)
    assert told["largest"] == pytest.approx(3.0)
    assert told["covered"] == pytest.approx(66.67)
    assert np.isnan(summarise([])["median"])


def test_rivals_on_a_square():
    x, y = (a.ravel() * 0.01 for a in np.mgrid[:11, :11])
    xyz = np.stack([x, y, 0.0 * x], axis=1)
    assert hull_area(xyz) == pytest.approx(0.01)
    assert delaunay_area(xyz) == pytest.approx(0.01)
    assert not keep_inliers(np.vstack([xyz, [[0.05, 0.05, 0.3]]]))[-1]


def test_goals():
    row = {"scans": "ours", "cleaned": "x", "way": "mesh", "judged": "yes", "covered": 95.0}
    goals = judge(
        [
            {**row, "kind": "flat", "median": -4.0, "p90": 5.0},
            {**row, "kind": "all", "median": 0.0, "p90": 0.0},
        ],
        [{"scan": "s", "ghosts": "by truth", "f1": 0.95}],
    )
    assert [g.verdict for g in goals] == ["NOT REACHED", "reached", "reached", "reached"]
