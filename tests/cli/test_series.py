"""The command series: a folder in, a table out that the command fit takes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.cli import run
from app.services.simulation import Targets
from app.services.simulation_order import Order
from app.services.simulation_series import simulate_series

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Leaves in a frame that turns, seen in reflectance at two wavelengths."""
    out = tmp_path_factory.mktemp("cli") / "frame"
    order = Order("leaf_frame", instrument="two_colour", step_deg=0.06)
    simulate_series(order, "frame.angle_deg=-30:30:15", Targets(out))
    return out


def test_series_and_fit(folder: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "table.csv"
    words = ["series", str(folder), "--leaves", str(folder / "leaf_frame_angle_deg_0.laz")]
    words += ["--label-field", "truth_leaf", "--angle-from", str(folder / "series.csv")]
    assert run([*words, "--axis", "fit", "--out", str(out)], debug=True) == 0
    printed = capsys.readouterr().out
    assert "5 scans: key, value from series.csv" in printed
    assert "axis: through 4" in printed
    assert "60 rows (60 sure)" in printed
    assert run([*words, "--out", str(out), "--json"]) == 3  # the table is there already
    assert run([*words, "--out", str(out), "--json", "--overwrite", "--same-pose"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["axis"] is None
    assert len(answer["rows"]) == 60
    assert run([*words, "--out", str(out), "--overwrite"]) == 0
    capsys.readouterr()
    fit = ["fit", str(out), "--x", "incidence_plane_deg", "--y", "reflectance_1545_mean"]
    assert run([*fit, "--group", "leaf", "--model", "lambert-beckmann", "--json"]) == 0
    fits = json.loads(capsys.readouterr().out)["fits"]
    assert [one["group"]["leaf"] for one in fits] == [f"leaf-{k:05d}" for k in range(1, 13)]
    assert all(one["n"] == 5 and one["parameters"]["f"]["value"] > 0.1 for one in fits)


def test_leaves_are_found_where_nobody_named_them(
    folder: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "table.csv"
    words = ["series", str(folder), "--leaves", "find", "--out", str(out), "--json"]
    assert run(words, debug=True) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["reference"].endswith("_0.laz")
    assert len({row["leaf"] for row in answer["rows"]}) >= 12


def test_a_bad_scan_is_told_and_the_exit_code_says_so(
    folder: Path, tmp_path: Path, capsys: Capture
) -> None:
    (tmp_path / "leaf_frame_angle_deg_5.laz").write_bytes(b"LASF no")
    words = ["series", *map(str, folder.glob("*_deg_*0.laz"))]
    words += [str(tmp_path / "leaf_frame_angle_deg_5.laz")]
    words += ["--leaves", str(folder / "leaf_frame_angle_deg_0.laz")]
    words += ["--label-field", "truth_leaf", "--out", str(tmp_path / "t.csv")]
    assert run(words) == 3
    said = capsys.readouterr()
    assert "1 of 4 scans could not be used" in said.err
    assert "note: leaf_frame_angle_deg_5.laz: " in said.out


@pytest.mark.parametrize(
    ("more", "code", "says"),
    [
        (["--leaves", "find", "--axis", "fit", "--same-pose"], 2, "turn about no axis"),
        (["--leaves", "find", "--angle-from", "1,2"], 2, "5 scans and 2 values"),
        (["--leaves", "find", "--movement", "-1"], 2, "length from 0"),
        (["--leaves", "leaf_frame_angle_deg_0.laz"], 2, "--label-field"),
    ],
)
def test_mistakes(
    folder: Path, tmp_path: Path, capsys: Capture, more: list[str], code: int, says: str
) -> None:
    assert run(["series", str(folder), "--out", str(tmp_path / "t.csv"), *more]) == code
    assert says in capsys.readouterr().err
