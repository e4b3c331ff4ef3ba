"""``leafscope mesh`` and ``leafscope leaves --seeds``: what they take, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.cli import run
from app.services.reading import read_file

Capture = pytest.CaptureFixture[str]


def test_normals_from_intensity_need_a_curve(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "leaves.ply"
    assert run(["mesh", str(leaves_file), "--out", str(out), "--steep-normals", "intensity"]) == 2
    assert "--curve TABLE" in capsys.readouterr().err
    assert run(["mesh", str(leaves_file), "--out", str(out), "--curve", "no.csv"]) == 2
    assert "belongs to --steep-normals" in capsys.readouterr().err
    assert not out.exists()


def test_seeds_name_leaves(leaves_file: Path, tmp_path: Path, capsys: Capture) -> None:
    scan = read_file(leaves_file)[0]
    x, y, z = scan.xyz[scan.attributes["truth_leaf"] == 0][0].tolist()
    seeds = tmp_path / "seeds.csv"
    seeds.write_text(f"leaf,x,y,z\nflag,{x},{y},{z}\n", encoding="utf-8")
    given = ["--label-field", "truth_leaf", "--seeds", str(seeds), "--json"]
    for command, out in (("leaves", "a.csv"), ("mesh", "a.ply")):
        assert run([command, str(leaves_file), "--out", str(tmp_path / out), *given]) == 0
        names = [row["name"] for row in json.loads(capsys.readouterr().out)["leaves"]]
        assert names.count("flag") == 1
    seeds.write_text(f"leaf,x,y,z\nflag,{x + 5},{y},{z}\n", encoding="utf-8")
    assert run(["leaves", str(leaves_file), "--out", str(tmp_path / "b.csv"), *given]) == 3
    assert "from the nearest point of a leaf" in capsys.readouterr().err
    assert not (tmp_path / "b.csv").exists()
