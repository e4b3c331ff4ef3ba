"""The bench of fits runs, reports what it promises, and its checks can fail."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, Cancelled
from app.core.fitting import fit
from app.core.progress import LiveProgress
from app.services.bench.fit import coverage, goals, speed, stability, trade
from app.services.bench.fit.curves import (
    BECKMANN,
    NAMES,
    STEPS,
    draw_curve,
    fit_with_scipy,
    make_curves,
)
from app.services.bench.fit.pictures import draw_costs
from app.services.bench.fit.run import TABLES, bench_fit, refuse_bench_fit
from app.services.bench.results import write_bench


@pytest.fixture
def small(monkeypatch):
    """Even less than --quick takes."""
    monkeypatch.setattr(speed, "QUICK_GROUPS", 30)
    monkeypatch.setattr(speed, "QUICK_JUDGED", 4)
    monkeypatch.setattr(speed, "STARTS", 2)
    monkeypatch.setattr(speed, "QUICK_REPEATS", 1)
    monkeypatch.setattr(trade, "QUICK_CURVES", 2)
    monkeypatch.setattr(coverage, "QUICK_SEEDS", 4)
    monkeypatch.setattr(coverage, "NOISES", (0.0035,))


def test_the_bench_runs_and_writes_its_tables_and_its_picture(small, tmp_path):
    bench = bench_fit(quick=True)
    assert tuple(table.name for table in bench.tables) == TABLES
    assert all(table.rows for table in bench.tables)
    written = write_bench(bench, tmp_path)
    assert all(path.stat().st_size > 100 for path in written)
    with pytest.raises(BadInput, match="exists"):
        refuse_bench_fit(tmp_path, overwrite=False)
    refuse_bench_fit(tmp_path, overwrite=True)


def test_the_bench_can_be_cancelled():
    with pytest.raises(Cancelled):
        bench_fit(quick=True, progress=LiveProgress(lambda *_: None, lambda: True))


def test_the_plain_formula_is_the_model():
    values = dict(zip(NAMES, (2.0, 0.4, 0.3), strict=True))
    np.testing.assert_allclose(draw_curve(STEPS, **values), BECKMANN.evaluate(STEPS, values))


def test_scipy_finds_an_easy_curve_in_its_own_units():
    found, rss = fit_with_scipy(STEPS, draw_curve(STEPS, 640.0, 0.5, 0.3))
    assert found == pytest.approx([640.0, 0.5, 0.3], rel=1e-5)
    assert rss == pytest.approx(0.0, abs=1e-6)


def test_a_wide_search_is_never_worse_than_one_start():
    value = make_curves(4, 3, 0.2).value
    once = [fit_with_scipy(STEPS, row)[1] for row in value]
    ours = [fit(BECKMANN, STEPS, row).rss for row in value]
    wide = speed.search_widely(value)
    assert (wide <= np.array(once) * (1 + 1e-6)).all()
    assert (np.array(ours) <= wide * (1 + 1e-9)).all()


def test_every_case_at_the_edge_is_right_or_refused():
    rows = stability.check_stability(quick=True).rows
    wrong = [row for row in rows if row["verdict"] == "WRONG"]
    assert not wrong
    assert sum(row["verdict"] == "refused" for row in rows) == 5
    assert all(row["words"] for row in rows if row["verdict"] == "refused")


def test_a_wrong_fit_at_the_edge_is_told():
    value = draw_curve(STEPS, 1.0, 0.5, 0.3)
    near = stability._near(1.0, 0.6, 0.3)
    assert stability.try_case(stability.Case("", STEPS, value, near))["verdict"] == "WRONG"
    assert stability.try_case(stability.Case("", STEPS, value, None))["verdict"] == "WRONG"
    refused = stability.try_case(stability.Case("", STEPS[:2], value[:2], near))
    assert refused["verdict"] == "WRONG"


def test_the_printed_leaves_are_all_there_and_found_again():
    rows = coverage.recover_printed().rows
    assert [row["count"] for row in rows] == [42, 14]
    assert [row["verdict"] for row in rows] == ["reached", "reached"]
    assert rows[1]["m_not_determined"] == 14


def test_coverage_counts_what_intervals_hold():
    ends = np.array([[[0.0, 2.0], [0.5, 0.6], [np.nan, np.nan]]])
    held = coverage._hold(ends, np.array([1.0, 0.7, 0.3]))
    assert held[0, :2].tolist() == [1.0, 0.0]
    assert np.isnan(held[0, 2])


def test_goals_name_what_is_missed(small):
    tables = {table.name: [dict(row) for row in table.rows] for table in bench_fit(True).tables}
    tables["fit_batch"][-1]["above_best"] = 3
    tables["fit_stability"][0]["verdict"] = "WRONG"
    missed = {goal.what for goal in goals.judge_all(tables) if goal.verdict != "reached"}
    assert {"worse than the best of 20 starts", "neither right nor refused"} <= missed


def test_the_picture_is_drawn(tmp_path):
    rows = [
        {"noise_percent": 6.0, "way": way, "ms_per_fit": 1.0 + i, "largest_excess": i * 1e-9}
        for i, way in enumerate(trade.WAYS)
    ]
    draw_costs(rows, tmp_path / "fit.png")
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
