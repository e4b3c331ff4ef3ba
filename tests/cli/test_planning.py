"""The command plan: a table, a figure, JSON; mistakes said in one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.cli import run

LEAF = ["plan", "--instrument", "ls880", "--leaf", "80x45"]


def test_it_writes_what_it_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, figure = tmp_path / "plan.csv", tmp_path / "plan.pdf"
    words = [*LEAF, "--range", "2:4:1", "--step", "0.018"]
    assert run([*words, "--out", str(table), "--figure", str(figure)]) == 0
    said = capsys.readouterr().out
    assert said.count("degrees usable at") == 3
    assert "HALF" in said
    assert figure.read_bytes().startswith(b"%PDF")
    assert len(table.read_text().splitlines()) == 1 + 3 * 18
    assert run([*words, "--out", str(table)]) == 3


def test_json_and_an_own_beam(capsys: pytest.CaptureFixture[str]) -> None:
    own = ["plan", "--leaf", "80x45", "--exit-diameter", "3", "--half-divergence", "0.014"]
    assert run([*own, "--step", "0.018", "--range", "4", "--omega", "60", "--json"]) == 0
    mine = json.loads(capsys.readouterr().out)
    assert mine["rows"][0]["footprint_mm"] == pytest.approx(9.91, abs=0.01)
    pulsed = ["--ranging", "pulsed", "--pulse-length", "0.2", "--behind", "none"]
    assert run([*own, "--step", "0.018", "--range", "4", "--omega", "60", *pulsed, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"][0]["ghost_share"] == 0.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*LEAF, "--omega", "0:90"], "no footprint"),
        ([*LEAF, "--step", "0"], "step between beams"),
        ([*LEAF, "--range", "0.1:3"], "measures from 0.6"),
        ([*LEAF[:-1], "80x2"], "no beam falls wholly"),
        ([*LEAF, "--behind", "wall"], "--behind takes"),
        ([*LEAF, "--behind", "inf"], "--behind takes"),
        ([*LEAF, "--behind", "-1"], "--behind takes"),
        ([*LEAF, "--behind", "0"], "--behind takes"),
        ([*LEAF, "--most-footprint", "1e9"], "up to 500 %"),
        ([*LEAF, "--most-footprint", "nan"], "above 0"),
        ([*LEAF, "--most-ghosts", "400"], "up to 100 %"),
        ([*LEAF, "--full-hits", "inf"], "fewest full hits"),
        ([*LEAF[:-1], "-80x45"], "two sides"),
        ([*LEAF, "--exit-diameter", "3"], "brings its own"),
        ([*LEAF, "--ranging", "pulsed"], "brings its own"),
        ([*LEAF, "--ranging", "phase-shift"], "brings its own"),
        ([*LEAF, "--pulse-length", "0.2"], "brings its own"),
        ([*LEAF, "--out", "plan.txt"], "Endings"),
        ([*LEAF, "--figure", "plan.txt"], "Endings"),
        (["plan", "--leaf", "80x45"], "needs --instrument"),
        (["plan", "--leaf", "80x45", "--exit-diameter", "3", "--half-divergence", "0.1",
          "--step", "0.1", "--ranging", "pulsed"], "belong together"),
        (["plan", "--leaf", "80x45", "--instrument", "nobody"], "no instrument"),
    ],
)  # fmt: skip
def test_mistakes_are_sentences(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words) == 2
    assert said in capsys.readouterr().err


def test_a_table_and_a_figure_are_two_files(tmp_path: Path) -> None:
    same = tmp_path / "plan.csv"
    assert run([*LEAF, "--out", str(same), "--figure", str(same.with_suffix(".png"))]) == 0
    assert run([*LEAF, "--out", str(same), "--overwrite"]) == 0


def test_either_order_of_the_sides_says_which_is_which(capsys: pytest.CaptureFixture[str]) -> None:
    told = []
    for leaf in ("80x45", "45x80", "45X80", "80×45"):
        assert run([*LEAF[:-1], leaf, "--range", "3"]) == 0
        told.append(capsys.readouterr().out)
    assert len(set(told)) == 1
    assert "leaf 80 mm long and 45 mm wide" in told[0]


@pytest.mark.parametrize("name", ["ls880", "two_colour"])
def test_ranging_is_said_once(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", "--instrument", name, "--leaf", "80x45", "--range", "3"]) == 0
    assert capsys.readouterr().out.splitlines()[0].count("phase shift") == 1
