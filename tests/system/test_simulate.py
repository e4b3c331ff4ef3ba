"""`leafscope simulate` as a user types it: answers, exit codes, files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli import run
from app.simulate.instrument import Instrument, list_instruments
from app.simulate.scene_file import list_scenes

Capture = pytest.CaptureFixture[str]
MINE = """\
name = "mine"
step_deg = 0.1
[[part]]
kind = "leaf"
name = "leaf_1"
tilt_deg = 40
[[part]]
kind = "wall"
range = 4
"""


def answer(capsys: Capture, *words: object) -> Any:
    assert run(["simulate", *map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_scenes_and_instruments_are_listed(capsys: Capture) -> None:
    found = answer(capsys, "--list")
    assert [scene["name"] for scene in found["scenes"]] == list(list_scenes())
    assert [tool["name"] for tool in found["instruments"]] == [t.name for t in list_instruments()]
    assert all(scene["description"] for scene in found["scenes"])
    assert run(["simulate", "--list"]) == 0
    said = capsys.readouterr().out
    assert "One bent leaf" in said
    assert "--series: stage.angle_deg, 0 to 85" in said
    assert "690 nm" in said


@pytest.mark.parametrize("name", list_scenes())
def test_a_ready_scene_can_be_copied(
    name: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.simulate.scene_file import get_scene, read_scene

    assert run(["simulate", "--show", name]) == 0
    copy = tmp_path / "copy.toml"
    copy.write_text(capsys.readouterr().out)
    assert read_scene(copy) == get_scene(name)


@pytest.mark.parametrize("tool", list_instruments(), ids=lambda tool: tool.name)
def test_an_instrument_can_be_copied(tool: Instrument, tmp_path: Path, capsys: Capture) -> None:
    from app.simulate.instrument import read_instrument

    assert run(["simulate", "--show", tool.name]) == 0
    copy = tmp_path / "copy.toml"
    copy.write_text(capsys.readouterr().out)
    assert repr(read_instrument(copy)) == repr(tool)


def test_a_scan_in_a_process_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(MINE)
    words = ["simulate", "mine.toml", "--out", "a.npz", "--leaves", "a.csv", "--set",
             "leaf_1.tilt_deg=10", "--noise", "none", "--seed", "7"]  # fmt: skip
    ran = subprocess.run(
        [sys.executable, "-m", "app.cli", *words],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    first, *rest = ran.stdout.splitlines()
    assert first.startswith("mine, Two colours, phase shift: ")
    assert "M beams/s." in first
    assert rest == ["a.csv written.", "a.npz written."]
    with np.load(tmp_path / "a.npz") as written:
        angle = written["truth_incidence"][written["truth_leaf"] == 0]
    assert np.median(angle) == pytest.approx(10, abs=1)


def test_json_is_plain(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "a.laz"
    found = answer(capsys, "leaf", "--out", out, "--step-deg", 0.1)
    assert found["file"] == str(out)
    assert (found["scene"], found["seed"], found["step_deg"]) == ("leaf", 0, 0.1)
    for key in ("points", "beams"):
        assert isinstance(found[key], int)
    for key in ("ghosts", "seconds", "million_beams_per_second"):
        assert isinstance(found[key], float)
    info = json.loads(_say(capsys, "info", str(out), "--json"))
    assert info["points"] == found["points"]


def test_a_series_alone_is_the_scenes_own(tmp_path: Path, capsys: Capture) -> None:
    words = ["shoot", "--step-deg", "0.3", "--series", "--out", str(tmp_path / "shoot")]
    found = answer(capsys, *words)
    assert len(found["steps"]) == 9
    assert len((tmp_path / "shoot" / "series.csv").read_text().splitlines()) == 10
    assert run(["simulate", *words]) == 3
    assert "exists already" in capsys.readouterr().err
    assert run(["simulate", *words, "--overwrite"]) == 0
    assert "shoot_1.angle_deg 80: " in capsys.readouterr().out


def test_a_series_over_instruments_names_them_all(tmp_path: Path, capsys: Capture) -> None:
    series = ["--series", "instrument=x330,salca", "--out", str(tmp_path)]
    assert run(["simulate", "leaf", "--step-deg", "0.3", *series]) == 0
    said = capsys.readouterr().out
    assert "leaf, FARO X330; SALCA, 2 scans over instrument: " in said


def test_a_scan_without_points_says_so(tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "edge.toml"
    scene.write_text("name = 'edge'\nstep_deg = 0.1\n[[part]]\nkind = 'leaf'\ntilt_deg = 89.9\n")
    out = str(tmp_path / "edge.laz")
    assert run(["simulate", str(scene), "--out", out]) == 0
    assert "note: No beam brought back enough" in capsys.readouterr().out
    assert run(["simulate", str(scene), "--out", str(tmp_path), "--series", "seed=1,2"]) == 0
    said = capsys.readouterr().out
    assert "note: edge_seed_1.laz: No beam brought back enough" in said


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("", 2, "--list"),
        ("leaf", 2, "--out"),
        ("nothing --out a.laz", 2, "pear_row"),
        ("--show nothing", 2, "pear_row"),
        ("--show nothing", 2, "x330"),
        ("--show ../instruments/x330", 2, "x330"),
        ("leaf --out a.laz --instrument nothing", 2, "two_colour"),
        ("leaf --out a.laz --instrument bad.toml", 3, "bad.toml"),
        ("bad.toml --out a.laz", 3, "bad.toml"),
        ("missing.toml --out a.laz", 3, "missing.toml"),
        ("leaf --out a.laz --set leaf_1.bogus=1", 2, "bogus"),
        ("leaf --out a.laz --set nobody.tilt_deg=1", 2, "nobody"),
        ("leaf --out a.laz --set leaf_1.tilt_deg", 2, "PATH=VALUE"),
        ("leaf --out a.laz --noise pink", 2, "noise"),
        ("leaf --out a.laz --waveforms w.npz", 2, "digitises no waveform"),
        ("leaf --out a.docx", 2, ".docx"),
        ("leaf --out nowhere/a.laz", 3, "nowhere"),
        ("leaf --out b --series", 2, "no series"),
        ("leaf --out b --series seed=1,1", 2, "Two steps"),
    ],
)
def test_errors_are_one_sentence_with_the_right_code(
    words: str, code: int, said: str, tmp_path: Path, capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    Path("bad.toml").write_text("name = 'a'\nname = 'b'\n")
    assert run(["simulate", *words.split()]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.strip().splitlines()) == 1
    assert captured.err.startswith("leafscope: ")
    assert said in captured.err
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_where_nothing_may_be_written(tmp_path: Path, capsys: Capture) -> None:
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o555)
    # Root may write to any folder, but nobody to one that the system makes up.
    out = folder / "a.laz" if os.access(folder, os.W_OK) is False else Path("/proc/a.laz")
    assert run(["simulate", "leaf", "--step-deg", "0.2", "--out", str(out)]) == 3
    assert "leafscope: " in capsys.readouterr().err


def test_a_polite_kill_cancels_with_code_4(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "app.cli", "simulate", "scattered", "--step-deg", "0.004",
               "--out", str(tmp_path / "a.laz")]  # fmt: skip
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(4)
    process.terminate()
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert err.decode().strip() == "leafscope: Cancelled."
    assert list(tmp_path.iterdir()) == []


def _say(capsys: Capture, *words: str) -> str:
    assert run(words) == 0
    return capsys.readouterr().out
