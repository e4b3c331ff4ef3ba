"""Spread of an index against the footprint: a tree of directions says the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.core.errors import MissingChannel, WrongUse
from app.core.synthetic_footprint import smooth
from app.model.operations import AddScan, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.services.export import provenance
from app.services.leaves import leaves_from_labels
from app.services.synthetic_footprints import (
    find_reached,
    set_synthetic_footprint,
    spread_of_index,
)

SIZES = (0.02, 0.1, 0.4)


@pytest.fixture
def opened(leaves: Scan) -> tuple[Project, str]:
    project = Project()
    key = project.shelve(leaves)
    project.do(AddScan(key, leaves.name, None))
    return project, key


def test_the_spread_falls_and_the_size_for_an_error_is_told(opened: tuple[Project, str]) -> None:
    project, key = opened
    names = leaves_from_labels(project, key, "truth_leaf")
    found = spread_of_index(project, key, "ndi", SIZES, leaves=names, error=0.03)
    sd = [row["sd"] for row in found.rows]
    assert sd == sorted(sd, reverse=True)
    assert [row["diameter_mm"] for row in found.rows] == [0.0, 20.0, 100.0, 400.0]
    scan = project.state.scan(key).scan
    values = np.array([scan.channel_values(name) for name in found.index.channels])
    on_leaf = np.zeros(len(scan), bool)
    for leaf in project.state.leaves_of(key):
        on_leaf[leaf.members.indices] = True
    on_leaf &= np.isfinite(values).all(axis=0)
    rows = np.flatnonzero(on_leaf)
    for row in found.rows[1:]:
        by_tree = smooth(
            values, scan.xyz, scan.scanner("it"), None, row["diameter_mm"] / 1000, rows, ~on_leaf
        )
        a, b = by_tree.values
        np.testing.assert_allclose(row["sd"], ((a - b) / (a + b)).std(ddof=1), rtol=0.03)
    assert found.reached_mm is not None
    assert sd[-1] <= 0.03 < sd[0]


def test_deleted_points_do_not_count(opened: tuple[Project, str]) -> None:
    project, key = opened
    scan = project.state.scan(key).scan
    before = spread_of_index(project, key, "ndi", (0.1,)).rows
    wall = np.flatnonzero(scan.attributes["truth_leaf"] < 0)
    project.do(SetDeleted(key, PointSet(wall)))
    after = spread_of_index(project, key, "ndi", (0.1,)).rows
    assert after[0]["n"] < before[0]["n"]
    assert after[1]["points"] != before[1]["points"]
    kept = scan.attributes["truth_leaf"] >= 0
    values = np.array([scan.channel_values(name) for name in ("reflectance_1063",)])
    rows = np.flatnonzero(kept & np.isfinite(values[0]))
    found = smooth(values, scan.xyz, scan.scanner("it"), scan.grid, 0.1, rows, ~kept)
    assert after[1]["points"] == np.median(found.count)


def test_the_size_lies_between_the_sizes_that_were_tried() -> None:
    def rows(*sd: float | None) -> list[dict[str, float | None]]:
        return [
            {"diameter_mm": s, "sd": v} for s, v in zip((0.0, 10.0, 40.0, 160.0), sd, strict=True)
        ]

    np.testing.assert_allclose(find_reached(rows(0.5, 0.4, 0.1, 0.05), 0.2), 20.0)
    assert find_reached(rows(0.5, 0.1, 0.4, 0.3), 0.2) is None
    assert find_reached(rows(0.1, 0.1, 0.1, 0.1), 0.2) == 0.0
    assert find_reached(rows(0.5, 0.1, 0.1, 0.1), 0.2) == 10.0
    np.testing.assert_allclose(find_reached(rows(0.5, 0.1, 0.4, 0.1), 0.2), 80.0)


def test_a_slider_drag_is_one_step(opened: tuple[Project, str]) -> None:
    project, key = opened
    steps = len(project.history.done)
    for diameter in (0.02, 0.03, 0.05):
        set_synthetic_footprint(project, key, diameter, "drag 1")
    assert len(project.history.done) == steps + 1
    assert "ndi_smoothed" in project.catalogue(key)
    told = provenance(project, key)
    assert told["synthetic_footprint"] == 0.05
    project.undo()
    assert project.state.scan(key).parameters.synthetic_footprint is None


def test_what_is_refused(opened: tuple[Project, str]) -> None:
    with pytest.raises(WrongUse, match="diameter"):
        spread_of_index(*opened, "ndi", (0.0,))
    with pytest.raises(WrongUse, match="positive"):
        spread_of_index(*opened, "ndi", SIZES, error=0.0)
    with pytest.raises(MissingChannel):
        spread_of_index(*opened, "wi", SIZES)


def test_the_command(leaves_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "spread.csv"
    words = ["synthetic-footprint", str(leaves_file), "--out", str(out), "--size", "50"]
    index = "(r1063 - r1545) / (r1063 + r1545)"
    given = [*words, "--index", index, "--label-field", "truth_leaf", "--error", "0.000001"]
    assert run(given) == 0
    said = capsys.readouterr().out
    assert "0 nm off" in said
    assert "is not reached" in said
    assert len(out.read_text().splitlines()) == 3
