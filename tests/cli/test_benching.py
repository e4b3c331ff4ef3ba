"""The commands of the benches: what they run, print and write."""

from __future__ import annotations

import csv
import json

import pytest

from app.cli import run


def test_incidence_quickly(tmp_path, capsys):
    out = tmp_path / "found"
    assert run(["bench", "incidence", "--quick", "--out", str(out)], debug=True) == 0
    printed = capsys.readouterr().out
    assert "What must be reached" in printed
    assert "not asked: give --peers" in printed
    names = ["incidence", *(f"incidence_{n}" for n in ("goals", "coverage", "bound", "kinds"))]
    for name in (*names, "incidence_programs"):
        with (out / f"{name}.csv").open(encoding="utf-8") as file:
            assert list(csv.DictReader(file)), name
    assert (out / "incidence.png").stat().st_size > 20_000
    assert set(names) <= set(json.loads((out / "incidence.json").read_text())["tables"])
    assert run(["bench", "incidence", "--quick", "--out", str(out)]) == 3
    assert "incidence.json" in capsys.readouterr().err


@pytest.mark.parametrize("radius", ["0", "-1", "nan"])
def test_a_radius_must_be_positive(radius, capsys):
    assert run(["bench", "incidence", "--quick", f"--radius={radius}"]) == 2
    assert "radius must be positive" in capsys.readouterr().err


def test_stability_quickly(tmp_path, capsys):
    assert run(["bench", "stability", "--quick", "--out", str(tmp_path)], debug=True) == 0
    assert "elevation" in capsys.readouterr().out
    with (tmp_path / "stability.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert all(row["verdict"] == "holds" for row in rows)
