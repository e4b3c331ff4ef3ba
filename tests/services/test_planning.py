"""Plans as a service: orders, words, tables and figures."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.core.mixing import PhaseMixing, PulseMixing
from app.core.planning import Limits
from app.model.scan import Scan
from app.model.state import ScanState
from app.services.beams import typed_beam
from app.services.plan_figure import choose_ranges, draw_plan
from app.services.plan_files import COLUMNS, as_dict, write_plan
from app.services.plan_leaf import measure_leaf, range_of
from app.services.plan_texts import choose_step, parse_leaf, parse_span, tell_range
from app.services.planning import PlanOrder, make_plan, tool_of, typed_tool
from app.simulate.instrument import list_instruments

ORDER = PlanOrder(tool_of("ls880"), 0.08, 0.0219, (2.16, 5.0), (0.0, 20.0, 65.0, 85.0))


def test_balduzzis_figure_7() -> None:
    plan = make_plan(replace(ORDER, behind=None, limits=Limits(0.45, 0.0, 1.0)))
    assert plan.share[0, 1:3] == pytest.approx([0.197, 0.438], abs=0.001)
    assert plan.reached_deg[0, 2] == pytest.approx(79.33, abs=0.01)
    here = plan.rows[0]
    assert here.bound == "footprint"
    assert here.footprint_share == pytest.approx(0.45, abs=1e-9)
    assert here.largest_deg == pytest.approx(65.7, abs=0.1)
    sentence = tell_range(here)
    assert sentence.startswith(
        "Up to 65 degrees usable at 2.2 m; the footprint then is 45 % of the leaf's width."
    )


def test_each_limit_can_bind_and_is_said() -> None:
    words = {
        "footprint": Limits(0.2, 0.0, 1.0),
        "full hits": Limits(5.0, 400.0, 1.0),
        "ghosts": Limits(5.0, 0.0, 0.5),
    }
    for bound, limits in words.items():
        row = make_plan(replace(ORDER, limits=limits)).rows[0]
        assert row.bound == bound, row
        assert {"footprint": "too long", "full hits": "too few", "ghosts": "too many"}[
            bound
        ] in tell_range(row)
    none = make_plan(replace(ORDER, limits=Limits(5.0, 1e6, 1.0))).rows[1]
    assert none.largest_deg is None
    assert tell_range(none).startswith("Not usable at 5.0 m, even at 0 degrees")


def test_instruments_bring_their_ranging() -> None:
    for known in list_instruments():
        tool = tool_of(known.name)
        assert tool.step_deg == known.step_deg
        assert isinstance(tool.mixing, PhaseMixing | PulseMixing)
        plan = make_plan(replace(ORDER, tool=tool, ranges=(3.0,)))
        assert plan.seen.points[0, 0] > 0
    assert tool_of("pulsed").mixing == PulseMixing(0.25, 0.05)
    assert tool_of("ls880", 0.036).step_deg == 0.036
    beam = typed_beam(3.0, 0.014)
    assert isinstance(typed_tool(beam, 0.1).mixing, PhaseMixing)
    assert typed_tool(beam, 0.1, 0.3).mixing == PulseMixing(0.3, 0.02)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": 0.003}, "no beam falls wholly on it"),
        ({"ranges": (0.1, 2.0)}, "measures from 0.6 to 76 m"),
        ({"ranges": (math.nan,)}, "measures from"),
        ({"ranges": ()}, "needs a range"),
        ({"angles_deg": (0.0, 90.0)}, "no footprint"),
        ({"angles_deg": (math.nan,)}, "no footprint"),
        ({"angles_deg": tuple(np.linspace(0, 80, 400))}, "at most"),
        ({"tool": replace(ORDER.tool, step_deg=0.0)}, "step between beams"),
        ({"tool": replace(ORDER.tool, step_deg=math.nan)}, "step between beams"),
        ({"behind": 0.0}, "stands behind"),
        ({"contrast": -1.0}, "stands behind"),
        ({"width": math.nan}, "must be above 0"),
    ],
)
def test_orders_without_an_answer_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(WrongUse, match=words):
        make_plan(replace(ORDER, **change))


def test_leaves_and_spans_are_read() -> None:
    assert parse_leaf("80x45") == (0.08, 0.045)
    assert parse_leaf("45×80") == (0.08, 0.045)
    for text in ("80", "80x", "0x45", "nanx4", "80x45x3", "1e9x2"):
        with pytest.raises(WrongUse, match="two sides"):
            parse_leaf(text)
    assert parse_span("2:4:0.7", "r") == (2.0, 2.7, 3.4, 4.0)
    assert parse_span("3", "r") == (3.0,)
    assert parse_span("2:20", "r")[:3] == (2.0, 3.0, 4.0)
    assert len(parse_span("0:85", "r")) == 18
    for text in ("5:2", "a:b", "1:2:3:4", "", "nan", "1:inf", "1:2:0", "1:2:-1", "0:1:1e-9"):
        with pytest.raises(WrongUse):
            parse_span(text, "--range")


def test_steps_are_round_and_few() -> None:
    for room in np.geomspace(1e-3, 1e4, 50):
        step = choose_step(float(room), 20)
        assert room / step <= 19 * (1 + 1e-9)
        assert room / step >= 19 / 2.5 * (1 - 1e-9)


def test_tables_hold_every_range_and_angle(tmp_path: Path) -> None:
    plan = make_plan(ORDER)
    table, whole = tmp_path / "plan.csv", tmp_path / "plan.json"
    write_plan(plan, table)
    write_plan(plan, whole)
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == 8
    assert float(rows[2]["footprint_mm"]) == pytest.approx(9.596, abs=0.001)
    assert {row["usable"] for row in rows} == {"yes", "no"}
    read = json.loads(whole.read_text())
    assert read == json.loads(json.dumps(as_dict(plan)))
    assert read["half_divergence_deg"] == pytest.approx(0.014)
    assert read["full_divergence_deg"] == pytest.approx(0.028)
    with pytest.raises(BadInput):
        write_plan(plan, table)
    with pytest.raises(WrongUse, match="Endings"):
        write_plan(plan, tmp_path / "plan.txt")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.csv", "plan.json"]


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"),
                                               ("pdf", b"%PDF")])  # fmt: skip
def test_figures_are_what_their_ending_says(tmp_path: Path, ending: str, start: bytes) -> None:
    many = make_plan(replace(ORDER, ranges=tuple(np.linspace(1.0, 60.0, 30)), width=0.08))
    path = tmp_path / f"plan.{ending}"
    draw_plan(many, path)
    assert path.read_bytes().startswith(start)
    with pytest.raises(BadInput):
        draw_plan(many, path)
    drawn = choose_ranges(many)
    assert len(drawn) == 6
    assert (drawn[0], drawn[-1]) == (0, 29)
    with pytest.raises(WrongUse):
        draw_plan(many, tmp_path / "plan.gif")


def test_a_leaf_of_a_scan_is_measured(leaves: Scan) -> None:
    state = ScanState.fresh(leaves)
    label = leaves.attributes["truth_leaf"]
    members = np.flatnonzero(label == np.bincount(label[label >= 0]).argmax()).astype(np.int64)
    seen = measure_leaf(state, members)
    away = np.linalg.norm(leaves.xyz[members] - leaves.pose.position, axis=1)
    assert seen.distance == pytest.approx(np.median(away), abs=0.02)
    assert range_of(state, int(members[0])) == pytest.approx(away[0])
    assert 0.01 < seen.width <= seen.length < 0.3
    with pytest.raises(BadInput, match="only 3 points"):
        measure_leaf(state, members[:3])


def test_the_size_of_a_flat_ellipse_is_found_among_ghosts() -> None:
    random = np.random.default_rng(8)
    turn, radius = random.uniform(0, 2 * np.pi, 4000), np.sqrt(random.uniform(size=4000))
    leaf = np.column_stack(
        (np.full(4000, 3.0), 0.02 * radius * np.cos(turn), 0.05 * radius * np.sin(turn))
    )
    ghosts = leaf[:300] * random.uniform(1.02, 1.3, (300, 1))
    line = leaf * [1.0, 0.0, 1.0]
    scan = make_scan(np.concatenate((leaf, ghosts)))
    seen = measure_leaf(ScanState.fresh(scan), np.arange(4300))
    assert seen == pytest.approx((3.0, 0.1, 0.04), rel=0.03)
    with pytest.raises(BadInput, match="on a line"):
        measure_leaf(ScanState.fresh(make_scan(line)), np.arange(4000))


def make_scan(xyz: np.ndarray) -> Scan:
    from app.model.scan import Pose

    return Scan("leaf", xyz, {}, (), Pose((0.0, 0.0, 0.0)))
