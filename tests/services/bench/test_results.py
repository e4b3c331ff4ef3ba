"""What benches share: tables, files, machine facts, pictures, timing, checks."""

from __future__ import annotations

import csv
import json
from functools import partial

import numpy as np
import pytest

from app.core.chunks import count_processors
from app.core.errors import BadInput, WrongUse
from app.services.bench.checks import compare, tabulate
from app.services.bench.machine import describe_machine
from app.services.bench.picture import Curve, Panel, draw_panels
from app.services.bench.results import Bench, ResultTable, write_bench
from app.services.bench.timing import can_choose_threads, time_in_turns, use_threads

ROWS = [{"leaves": 1, "µs": 0.25, "verdict": "agrees"}, {"leaves": 2, "µs": np.nan, "verdict": ""}]
TABLE = ResultTable("costs", "What it costs", ROWS)
PANEL = Panel(
    "Time", "leaves", "µs", (Curve("own", (1, 10), (2, 3)), Curve("other", (1, 2), (3, 4)))
)


def make_bench():
    return Bench("demo", (TABLE,), {"picture": partial(draw_panels, (PANEL, PANEL))})


def test_a_bench_becomes_csv_json_and_a_picture(tmp_path):
    written = write_bench(make_bench(), tmp_path / "new")
    assert [path.name for path in written] == ["demo.json", "costs.csv", "picture.png"]
    with (tmp_path / "new/costs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[0] == {"leaves": "1", "µs": "0.25", "verdict": "agrees"}
    whole = json.loads((tmp_path / "new/demo.json").read_text(encoding="utf-8"))
    assert whole["tables"]["costs"]["rows"][1] == {"leaves": 2, "µs": None, "verdict": ""}
    assert whole["machine"]["cores"] == str(count_processors())
    picture = (tmp_path / "new/picture.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 5000


def test_nothing_is_written_over_and_nothing_half(tmp_path):
    (tmp_path / "costs.csv").write_text("mine")
    with pytest.raises(BadInput, match="exists already"):
        write_bench(make_bench(), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["costs.csv"]

    def fail(path):
        path.write_text("half")
        raise OSError(28, "No space left")

    with pytest.raises(BadInput, match="No space"):
        write_bench(Bench("demo", (TABLE,), {"picture": fail}), tmp_path, overwrite=True)
    assert (tmp_path / "costs.csv").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_picture_needs_a_panel(tmp_path):
    with pytest.raises(WrongUse, match="without a panel"):
        draw_panels((), tmp_path / "none.png")


def test_machine_facts_name_processor_and_versions():
    facts = describe_machine()
    assert facts["processor"]
    assert facts["numpy"] == np.__version__


def test_rivals_take_turns():
    order = []
    rivals = {name: partial(order.append, name) for name in ("a", "b")}
    taken = time_in_turns(rivals, 3)
    assert order == ["a", "b"] * 3
    assert len(taken["a"].seconds) == 3
    assert min(taken["a"].seconds) <= taken["a"].median <= max(taken["a"].seconds)


@pytest.mark.skipif(not can_choose_threads(), reason="this system has no processor affinity")
def test_threads_are_limited_and_given_back():
    before = count_processors()
    with use_threads(1):
        assert count_processors() == 1
    assert count_processors() == before


def test_a_check_is_told_where_it_is_worst():
    check = compare("g", "what", [1.0, 2.0, 4.0], [1.0, 2.1, 4.1], 0.06, relative=True)
    assert (check.expected, check.found, check.count) == (2.0, 2.1, 3)
    assert check.deviation == pytest.approx(0.05)
    assert check.passed
    assert not compare("g", "what", [1.0, 2.0], [1.0, 2.2], 0.1).passed
    row = tabulate("name", "title", [check]).rows[0]
    assert row["verdict"] == "agrees"


@pytest.mark.parametrize("found", [[np.nan, 1.0], [1.0], []])
def test_no_number_and_other_counts_never_pass(found):
    assert not compare("g", "what", [1.0, 1.0], found, 1e9).passed
