"""Tables as users have them: gaps, radians, holder angles, odd names, and files to keep."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.formats.cloud import Cloud
from app.services.export import export
from app.simulate.scenes import leaf_row_scan

Capture = pytest.CaptureFixture[str]
ANGLES = (0.0, 20.0, 40.0, 60.0)


def write(path: Path, rows: Sequence[Sequence[object]]) -> Path:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return path


def read(path: Path) -> list[list[str]]:
    with path.open(newline="") as file:
        return list(csv.reader(file))


def fit(table: Path, *words: object) -> list[str]:
    texts = map(str, words)
    return ["fit", str(table), "--x", "w", "--y", "i", "--model", "lambert", *texts]


@pytest.fixture
def clashing(tmp_path: Path) -> Path:
    """Groups named as columns of results are."""
    rows = [
        [model, parameter, w, bright * np.cos(np.deg2rad(w)) + 0.001 * (w == 20)]
        for model, bright in (("oak", 1.0), ("elm", 2.0))
        for parameter in ("quantity", "red")
        for w in ANGLES
    ]
    return write(tmp_path / "t.csv", [["model", "parameter", "w", "i"], *rows])


def test_labels_and_results_have_columns_of_their_own(clashing: Path, tmp_path: Path) -> None:
    out = tmp_path / "long.csv"
    words = ["--group", "model", "--group", "parameter", "--table", out]
    assert run(fit(clashing, *words)) == 0
    head, *rows = read(out)
    assert len(set(head)) == len(head)
    first = dict(zip(head, rows[0], strict=True))
    assert (first["group_model"], first["group_parameter"]) == ("oak", "quantity")
    assert (first["model"], first["parameter"]) == ("lambert", "f")


def test_a_wide_table_has_no_column_twice(clashing: Path, tmp_path: Path) -> None:
    out = tmp_path / "wide.csv"
    words = ["--group", "model", "--group", "parameter", "--table", out, "--wide"]
    assert run(fit(clashing, *words)) == 0
    head, *rows = read(out)
    assert head == ["parameter", "quantity", "model", "group_quantity", "red"]
    assert rows[0][:3] == ["f", "value", "oak"]


def test_missing_numbers_are_left_out_and_counted(tmp_path: Path, capsys: Capture) -> None:
    words = ("NA", "NaN", "nan", "N/A", "", "-", "n/a")
    rows: list[list[object]] = [[w, np.cos(np.deg2rad(w)) + 0.001 * (w == 20)] for w in ANGLES]
    gaps: list[list[object]] = [[10, word] for word in words]
    table = write(tmp_path / "t.csv", [["w", "i"], *rows, *gaps, ["NA", 1.0]])
    assert run([*fit(table), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["fits"][0]["n"] == len(ANGLES)
    assert found["notes"] == [f"t.csv: {len(words) + 1} rows have no number in w or i."]
    write(table, [["w", "i"], *rows, [30, "none of it"]])
    assert run(fit(table)) == 3
    assert "row 6: 'none of it' in column i is not a number" in capsys.readouterr().err


def test_radians_and_holder_angles_are_guessed(tmp_path: Path, capsys: Capture) -> None:
    radians = [[np.deg2rad(w), np.cos(np.deg2rad(w))] for w in ANGLES]
    assert run(fit(write(tmp_path / "r.csv", [["w", "i"], *radians]))) == 0
    assert "column w, 0 to 1.05, look like radians" in capsys.readouterr().out
    turned = [[w, np.cos(np.deg2rad(w)) ** 2] for w in (-40.0, -20.0, *ANGLES)]
    table = write(tmp_path / "h.csv", [["w", "i"], *turned])
    assert run(fit(table)) == 0
    said = capsys.readouterr().out
    assert "note: Negative angles look like those of a holder" in said
    assert "radians" not in said
    assert run(["fit", str(table), "--x", "w", "--y", "i", "--model", "cosine"]) == 0
    assert "Negative angles" not in capsys.readouterr().out


def test_what_cannot_be_fitted_and_what_has_no_name(tmp_path: Path, capsys: Capture) -> None:
    rows = [["", w, np.cos(np.deg2rad(w)) + 0.001 * (w == 20)] for w in ANGLES] + [["b", 0, 1]]
    table = write(tmp_path / "t.csv", [["leaf", "w", "i"], *rows])
    assert run(fit(table, "--group", "leaf")) == 0
    said = capsys.readouterr().out
    assert "leaf (empty): lambert, 4 points" in said
    assert "leaf b: lambert, not fitted: lambert needs more pairs" in said
    assert "none" not in said


def test_index_angle_keeps_labels_and_tells_gaps(tmp_path: Path, capsys: Capture) -> None:
    rows: list[list[object]] = [
        [name, "x", w, 0.5 + 0.1 * np.cos(2 * np.deg2rad(w)), 0.3 + 0.01 * (w == 20)]
        for name in ("oak", "")
        for w in (-60.0, -40.0, -20.0, *ANGLES, 85.0)
    ]
    rows += [["oak", "x", "NA", 0.5, 0.3], ["oak", "x", 10, "-", 0.3]]
    head = ["index_mean", "curve", "w", "a", "b"]
    table, out, curve = write(tmp_path / "t.csv", [head, *rows]), tmp_path / "i.csv", "c.csv"
    words = ["index-angle", str(table), "--angle", "w", "--group", "index_mean", "--group", "curve"]
    words += ["--index", "ndi", "--channel", "a=1063", "--channel", "b=1545", "--out", str(out)]
    words += ["--curve", str(tmp_path / curve)]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "oak, x: NDI" in said or "oak, x: ndi" in said
    assert "(empty), x: " in said
    assert "note: t.csv: 2 rows have no number in w or a." in said
    assert "note: oak, x: points left out: 1 without an angle, 1 without the index." in said
    head, *found = read(out)
    first = dict(zip(head, found[0], strict=True))
    assert len(set(head)) == len(head)
    assert (first["group_index_mean"], first["curve"]) == ("oak", "x")
    assert 0.0 < float(first["index_mean"]) < 1.0
    assert [first[key] for key in ("n", "without_angle", "beyond_80", "undefined")] == [
        "8", "1", "0", "1",
    ]  # fmt: skip
    head, *lines = read(tmp_path / curve)
    assert head[:3] == ["index_mean", "group_curve", "curve"]
    assert {line[2] for line in lines} == {"measured", "fitted"}


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scan") / "row.laz"
    export(Cloud(leaf_row_scan(step_deg=0.2)), path)
    return path


COMMANDS = {
    "fit-scan": ["--model", "lambert", "--figure"],
    "correct": ["--out"],
    "index-angle": ["--index", "ndi", "--out"],
    "synthetic-footprint": ["--index", "ndi", "--out"],
    "sample": ["--out"],
    "leaves": ["--out"],
    "compute": ["--field", "range", "--out"],
    "clean": ["--mode", "mark", "--out"],
    "snapshot": ["--colour", "range", "--out"],
    "series": ["--leaves", "find", "--angle-from", "0", "--out"],
    "fit": ["--x", "w", "--y", "i", "--model", "lambert", "--figure"],
    "calibrate": ["--out"],
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("link", [False, True])
def test_no_command_replaces_what_it_reads(
    scan: Path, command: str, link: bool, tmp_path: Path, capsys: Capture
) -> None:
    ending = ".png" if command in ("fit", "fit-scan", "snapshot") else ".laz"
    source, target = tmp_path / f"source{ending}", tmp_path / f"source{ending}"
    source.write_bytes(scan.read_bytes())
    if link:
        target = tmp_path / f"link{ending}"
        target.symlink_to(source)
    before = source.read_bytes()
    assert run([command, str(source), *COMMANDS[command], str(target), "--overwrite"]) == 3
    assert "would replace the measurements" in capsys.readouterr().err
    assert source.read_bytes() == before


def test_reports_and_curves_replace_nothing_either(
    scan: Path, tmp_path: Path, capsys: Capture
) -> None:
    words = ["compute", str(scan), "--field", "range", "--out", str(tmp_path / "a.npz")]
    assert run([*words, "--report", str(scan), "--overwrite"]) == 3
    words = ["index-angle", str(scan), "--index", "ndi", "--out", str(tmp_path / "a.csv")]
    assert run([*words, "--curve", str(scan), "--overwrite"]) == 3
    assert capsys.readouterr().err.count("would replace the measurements") == 2
    assert run([*words, "--curve", str(tmp_path / "a.csv")]) == 3
    assert "two results" in capsys.readouterr().err


def test_the_angles_of_a_series_are_kept(scan: Path, tmp_path: Path, capsys: Capture) -> None:
    table = write(tmp_path / "series.csv", [["file", "angle"], [scan.name, 0]])
    words = ["series", str(scan), "--leaves", "find", "--angle-from", str(table)]
    assert run([*words, "--out", str(table), "--overwrite"]) == 3
    assert "would replace the measurements" in capsys.readouterr().err


def test_one_row_is_one_row(scan: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "i.csv"
    words = ["index-angle", str(scan), "--index", "ndi", "--out", str(out), "--together"]
    assert run([*words, "--label-field", "truth_leaf"]) == 0
    said = capsys.readouterr().out
    assert f"1 row; {out} written." in said
