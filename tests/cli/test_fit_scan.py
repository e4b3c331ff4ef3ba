"""Leaves × channels of a scan, fitted and written by one command."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from app.cli import run
from app.model.scan import Scan
from app.services.curves import fit_leaves, result_of
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, open_file

Capture = pytest.CaptureFixture[str]
LABELS = ("--label-field", "truth_leaf", "--radius", "0.02", "--model", "lambert")


@pytest.fixture(autouse=True)
def own_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LEAFSCOPE_MODELS", str(tmp_path / "own-models"))


def answer(capsys: Capture, *words: object) -> Any:
    assert run(["fit-scan", *map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_every_leaf_in_every_channel(
    leaves_file: Path, leaves: Scan, tmp_path: Path, capsys: Capture
) -> None:
    out, figure = tmp_path / "fits.csv", tmp_path / "fits.png"
    words = (leaves_file, *LABELS, "--out", out, "--wide", "--figure", figure)
    found = answer(capsys, *words)["fits"]
    assert len(found) == 2 * len(set(leaves.attributes["truth_leaf"]) - {-1})
    project, (key,) = open_file(Opening(leaves_file))
    project.set_parameters(key, radius=0.02)
    keys = leaves_from_labels(project, key, "truth_leaf")
    fitted = [one for one in found if one["rss"] is not None]
    assert len(fitted) >= 8
    for one in fitted:
        place = int(one["group"]["sample"].split()[1])
        record = fit_leaves(project, key, [keys[place]], "lambert", one["group"]["channel"])
        expected = result_of(record)
        assert one["parameters"]["f"]["value"] == pytest.approx(expected.values["f"], rel=1e-9)
        assert one["n"] == expected.n
    rows = list(csv.reader(out.open()))
    assert rows[0] == ["parameter", "quantity", "sample", "reflectance_1063", "reflectance_1545"]
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_leaves_together_in_one_channel_with_intervals(leaves_file: Path, capsys: Capture) -> None:
    words = (leaves_file, *LABELS, "--leaves", "together", "--channel", "reflectance_1063")
    more = ("--bootstrap", "--trials", "100", "--profile-intervals", "--compare", "--on", "bins")
    found = answer(capsys, *words, *more)
    (one,) = found["fits"]
    assert one["group"] == {"sample": "all leaves", "channel": "reflectance_1063"}
    assert one["kind"] == "bins"
    assert one["bootstrap"]["f"]["low"] < one["bootstrap"]["f"]["high"]
    assert one["profile"]["f"]["low"] < one["profile"]["f"]["high"]
    assert len(found["comparisons"][0]["models"]) == 7


def test_the_whole_scan_and_a_channel_named_by_hand(leaves_file: Path, capsys: Capture) -> None:
    words = (leaves_file, "--leaves", "scan", "--model", "lambert", "--radius", "0.02")
    (one, _) = answer(capsys, *words, "--on", "bins", "--angles", "0,80")["fits"]
    assert one["group"]["sample"] == "whole scan"
    assert one["angles_deg"][1] < 80.0
    named = ("--channel", "truth_hit_fraction=1550:linear", "--channel", "truth_hit_fraction")
    (hand,) = answer(capsys, *words, *named)["fits"]
    assert hand["group"]["channel"] == "truth_hit_fraction"


def test_a_table_of_fits_corrects_the_scan(leaves_file: Path, tmp_path: Path) -> None:
    fits, out = tmp_path / "fits.json", tmp_path / "corrected.csv"
    words = ("--leaves", "together", "--label-field", "truth_leaf", "--model", "incidence-b")
    assert run(["fit-scan", str(leaves_file), *words, "--out", str(fits)]) == 0
    correct = ["--correct", f"reflectance_1063:wf2:{fits}", "--fit", "none", "--out", str(out)]
    assert run(["correct", str(leaves_file), *correct, "--label-field", "truth_leaf"]) == 0
    (first, *_) = csv.DictReader(out.open())
    assert "fits.json" in first["wf2_by"]


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--model", "lambert", "--channel", "gone"], 3, "no channel gone"),
        (["--model", "lambert", "--label-field", "gone"], 2, "no field gone"),
        (["--model", "lambert", "--leaves", "scan", "--label-field", "truth_leaf"], 2, "whole"),
        (["--model", "lambert", "--bootstrap"], 2, "--leaves together"),
        (["--model", "lambert", "--out", "a.csv", "--table", "b.csv"], 2, "give one"),
        (["--model", "lambert", "--out", "a.doc"], 2, "Endings"),
        ([], 2, "Say which model"),
    ],
)
def test_bad_words_are_refused_in_a_sentence(
    leaves_file: Path, capsys: Capture, words: list[str], code: int, says: str
) -> None:
    assert run(["fit-scan", str(leaves_file), *words]) == code
    said = capsys.readouterr().err
    assert says in said
    assert len(said.strip().splitlines()) == 1
