"""The command sample: two scans in, a table out, mistakes said in one sentence."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from app.cli import run
from app.formats.cloud import Cloud
from app.model.scan import Channel, Scan
from app.services.export import export


@pytest.fixture(scope="module")
def two(leaves: Scan, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same leaves in one channel each, as raw numbers named intensity."""
    folder, paths = tmp_path_factory.mktemp("two"), []
    for nm in (1063, 1545):
        values = leaves.attributes[f"reflectance_{nm}"]
        attributes = {"intensity": values, "truth_leaf": leaves.attributes["truth_leaf"]}
        channel = Channel("intensity", "intensity", None, "DN")
        paths.append(folder / f"at_{nm}.laz")
        export(Cloud(replace(leaves, attributes=attributes, channels=(channel,))), paths[-1])
    return paths[0], paths[1]


def test_each_scan_gets_its_own_channel(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "table.csv"
    words = ["sample", *map(str, two), "--index", "ndi", "--label-field", "truth_leaf"]
    words += ["--channel", "1:intensity=1063:reflectance"]
    words += ["--channel", "2:intensity=1545:reflectance", "--out", str(out)]
    assert run([*words, "--pair-within", "0.5"], debug=True) == 0
    printed = capsys.readouterr().out
    assert "truth_leaf 3  ndi 0." in printed
    assert "100.0% of the points of at_1545" in printed  # one scan, twice: each point finds itself
    assert run([*words, "--json"]) == 3  # the table is there already
    assert run([*words, "--json", "--overwrite"]) == 0
    answer = json.loads(capsys.readouterr().out)
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(answer["samples"]) == 6
    assert float(rows[3]["ndi_of_means"]) == answer["samples"][3]["ndi_of_means"]
    assert answer["warnings"] == []


@pytest.mark.parametrize(
    ("more", "code", "says"),
    [
        (["--index", "ndi"], 3, "wavelength unknown"),
        (["--channel", "3:intensity=1063:DN"], 2, "there are 2 scans"),
        (["--index", "what"], 2, "no index"),
        (["--profile", "none"], 2, "1 profiles"),
        (["--index", "ndi", "--pair-within", "0", "--channel", "1:intensity=1063:DN",
          "--channel", "2:intensity=1545:DN"], 2, "positive distance"),
    ],
)  # fmt: skip
def test_mistakes(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str],
    more: list[str], code: int, says: str,
) -> None:  # fmt: skip
    out = tmp_path / "table.csv"
    assert run(["sample", *map(str, two), "--out", str(out), *more]) == code
    assert says in capsys.readouterr().err
    assert not out.exists()


def test_raw_numbers_are_warned_about(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["sample", *map(str, two), "--index", "ndi", "--out", str(tmp_path / "t.csv")]
    words += ["--channel", "1:intensity=1063:DN", "--channel", "2:intensity=1545:DN"]
    assert run(words, debug=True) == 0
    assert "raw DN" in capsys.readouterr().out
