"""``leafscope wrinkles``: its options, its files, and what it refuses."""

from __future__ import annotations

import csv
import json

import pytest

from app.cli import run

TABLE = "angle,value\n" + "\n".join(
    f"{angle},{0.27 - 0.0025 * angle - 0.00001 * angle**2}" for angle in range(0, 86, 5)
)


@pytest.fixture
def gonio(tmp_path):
    """A table of a goniometer."""
    path = tmp_path / "gonio.csv"
    path.write_text(TABLE)
    return path


def test_a_table_and_a_picture(leaves_file, gonio, tmp_path, capsys):
    out, picture = tmp_path / "table.csv", tmp_path / "map.png"
    words = [
        "wrinkles", str(leaves_file), "--out", str(out), "--leaves", "truth_leaf", "--curve",
        str(gonio), "--map", str(picture), "--wavelength", "reflectance_1545",
        "--instrument", "two_colour", "--json",
    ]  # fmt: skip
    assert run(words, debug=True) == 0
    told = json.loads(capsys.readouterr().out)
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(told["leaves"]) == 6
    assert {row["case"] for row in rows} == {"known"}
    assert picture.is_file()
    assert run(words) == 3  # the table is there already


def test_what_it_says(leaves_file, gonio, tmp_path, capsys):
    words = [
        "wrinkles", str(leaves_file), "--out", str(tmp_path / "t.csv"), "--label-field",
        "truth_leaf", "--curve", str(gonio), "--offset", "fit", "--wavelength",
        "reflectance_1545", "--means", "off",
    ]  # fmt: skip
    assert run(words, debug=True) == 0
    told = capsys.readouterr().out
    assert "only differences Δω inside the leaf are claimed" in told
    assert "6 leaves" in told


def test_with_nothing_but_the_scan(leaves_file, tmp_path, capsys):
    tables = []
    for number, more in enumerate(([], ["--own"], ["--species", "maple", "--offset", "fit"])):
        out = tmp_path / f"{number}.csv"
        words = ["wrinkles", str(leaves_file), "--out", str(out), "--leaves", "truth_leaf"]
        assert run([*words, "--wavelength", "reflectance_1545", *more], debug=True) == 0
        with out.open(encoding="utf-8") as file:
            tables.append(list(csv.DictReader(file)))
    headers = {tuple(table[0]) for table in tables}
    assert len(headers) == 1, "the columns are the same whatever is known"
    default, own, _ = tables
    assert {row["case"] for row in default} == {"levelled"}
    assert sum(bool(row["wrinkle_index_deg"]) for row in default) >= 2
    assert all("leaves of this scan" in row["curve"] for row in default)
    for row in default:
        assert bool(row["wrinkle_index_deg"]) != bool(row["refusal"])
    refused = [row["refusal"] for row in own if row["refusal"]]
    assert any("leave --own out" in refusal for refusal in refused), "flat leaves"


@pytest.mark.parametrize(
    ("more", "code"),
    [
        (["--own", "--species", "maple"], 2),
        (["--offset", "1.2"], 2),
        (["--own", "--offset", "1.2"], 2),
        (["--species", "oak"], 2),
        (["--species", "maple", "--curve", "x.csv"], 2),
        (["--species", "maple", "--model", "lambert"], 2),
        (["--species", "maple", "--scatter", "2"], 2),
        (["--reflectance", "0.4"], 2),
        (["--offset", "much"], 2),
        (["--curve", "missing.csv"], 3),
        (["--steepest", "100"], 2),
        (["--wavelength", "nothing"], 3),
        (["--map", "map.gif"], 2),
    ],
)
def test_what_it_refuses(leaves_file, tmp_path, capsys, more, code):
    out = tmp_path / "table.csv"
    words = ["wrinkles", str(leaves_file), "--out", str(out), "--leaves", "truth_leaf", *more]
    assert run(words) == code
    assert capsys.readouterr().err.startswith("leafscope: ")
    assert not out.exists()
