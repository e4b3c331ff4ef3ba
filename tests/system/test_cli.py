"""The command line as a user types it: answers, exit codes, files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli import run
from app.model.scan import Scan

Capture = pytest.CaptureFixture[str]


def answer(capsys: Capture, *words: object) -> Any:
    assert run([*map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_info(leaves_file: Path, leaves: Scan, capsys: Capture) -> None:
    found = answer(capsys, "info", leaves_file)
    assert found["points"] == len(leaves)
    assert found["grid"] == [leaves.grid.rows, leaves.grid.columns]
    assert found["scanner"] == pytest.approx(list(leaves.pose.position))
    assert [c["name"] for c in found["channels"]] == ["reflectance_1063", "reflectance_1545"]
    assert found["channels"][0] == {
        "name": "reflectance_1063",
        "wavelength_nm": 1063.0,
        "kind": "reflectance",
    }
    low, high = found["bounds"]
    assert all(a < b for a, b in zip(low, high, strict=True))


def test_compute_writes_a_row_per_point_in_file_order(
    leaves_file: Path, leaves: Scan, tmp_path: Path, capsys: Capture
) -> None:
    out, report_file = tmp_path / "out.npz", tmp_path / "report.json"
    assert (
        run(
            [
                "compute",
                str(leaves_file),
                "--field",
                "incidence",
                "--field",
                "ghost",
                "--radius",
                "0.02",
                "--out",
                str(out),
                "--report",
                str(report_file),
            ]
        )
        == 0
    )
    with np.load(out, allow_pickle=False) as written:
        np.testing.assert_allclose(written["xyz"], leaves.xyz, atol=1e-4)
        assert written["ghost"].dtype == bool
        angle = written["incidence"]
    inner = (leaves.attributes["truth_hit_fraction"] > 0.999) & np.isfinite(angle)
    error = np.abs(angle - leaves.attributes["truth_incidence"])[inner]
    assert np.median(error) < 3.0
    report = json.loads(report_file.read_text())
    assert set(report["seconds"]) == {"read", "incidence", "ghost", "write"}
    assert min(report["seconds"]["ghost"], report["seconds"]["incidence"]) > 0
    assert report["computed"] == {n: len(leaves) for n in ("incidence", "ghost_score", "ghost")}
    assert report["undefined"]["incidence"] == np.count_nonzero(~np.isfinite(angle))
    assert {"leafscope", "numpy", "numba"} <= set(report["versions"])


def test_compute_makes_the_curve_and_leaves_that_delta_omega_needs(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "out.npz"
    report = answer(
        capsys, "compute", leaves_file, "--field", "delta_omega", "--radius", "0.02", "--out", out
    )
    said = " ".join(report["warnings"])
    assert "Fit lambert-beckmann" in said
    assert "Find" in said
    with np.load(out) as written:
        assert np.isfinite(written["delta_omega"]).sum() > 100


def test_fit(tmp_path: Path, capsys: Capture) -> None:
    table = tmp_path / "angles.csv"
    angle = np.arange(0, 75, 5.0)
    rows = [
        f"{kind},{a},{f * np.cos(np.radians(a))}"
        for kind, f in (("a", 2.0), ("b", 3.0))
        for a in angle
    ]
    table.write_text("leaf,angle,value\n" + "\n".join(rows))
    found = answer(
        capsys,
        "fit",
        table,
        "--x",
        "angle",
        "--y",
        "value",
        "--group",
        "leaf",
        "--model",
        "lambert",
    )["fits"]
    assert [entry["group"] for entry in found] == [{"leaf": "a"}, {"leaf": "b"}]
    values = [entry["parameters"]["f"]["value"] for entry in found]
    assert values == pytest.approx([2.0, 3.0])
    assert found[0]["n"] == len(angle)
    assert found[0]["rss"] == pytest.approx(0.0, abs=1e-20)


def test_leaves_by_label(leaves_file: Path, leaves: Scan, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "leaves.csv"
    rows = answer(capsys, "leaves", leaves_file, "--label-field", "truth_leaf", "--out", out)
    labels = leaves.attributes["truth_leaf"]
    assert [row["points"] for row in rows["leaves"]] == np.bincount(labels[labels >= 0]).tolist()
    one = rows["leaves"][1]
    inside = leaves.attributes["reflectance_1063"][labels == 1].astype(float)
    assert one["reflectance_1063_mean"] == pytest.approx(inside.mean(), rel=1e-6)
    assert {"ndi_mean_of_points", "ndi_of_means", "incidence_plane_deg"} <= set(one)
    assert len(out.read_text().splitlines()) == len(rows["leaves"]) + 1


@pytest.mark.parametrize("mode", ["mark", "delete", "correct", "auto"])
def test_clean(leaves_file: Path, leaves: Scan, tmp_path: Path, capsys: Capture, mode: str) -> None:
    out = tmp_path / "clean.npz"
    found = answer(capsys, "clean", leaves_file, "--mode", mode, "--out", out)
    with np.load(out) as written:
        size = len(written["xyz"])
        moved = size == len(leaves) and np.abs(written["xyz"] - leaves.xyz).max() > 0.005
        marked = int(written["ghost"].sum()) if "ghost" in written.files else None
    assert found["ghosts"] > 0
    assert size == len(leaves) - found["deleted"]
    assert (found["deleted"] == found["ghosts"]) == (mode == "delete")
    assert moved == (mode == "correct")
    assert marked == (found["ghosts"] if mode == "mark" else None)


def test_snapshot(leaves_file: Path, tmp_path: Path) -> None:
    from matplotlib.image import imread

    out = tmp_path / "picture.png"
    assert (
        run(
            [
                "snapshot",
                str(leaves_file),
                "--colour",
                "range",
                "--size",
                "320x200",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    image = imread(out)
    assert image.shape[:2] == (200, 320)
    assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 50


WRONG_USE = [
    ["frobnicate"],
    ["info"],
    ["compute", "FILE", "--field", "beauty", "--out", "o.npz"],
    ["compute", "FILE", "--field", "range", "--out", "o.docx"],
    ["compute", "FILE", "--field", "range", "--out", "o.npz", "--origin", "1,2"],
    ["compute", "FILE", "--field", "range", "--out", "o.npz", "--radius", "-1"],
    ["fit", "TABLE", "--x", "angle", "--y", "value", "--model", "phong"],
    ["clean", "FILE", "--mode", "vanish", "--out", "o.npz"],
    ["snapshot", "FILE", "--colour", "range", "--size", "big", "--out", "o.png"],
    ["snapshot", "FILE", "--colour", "range", "--limits", "1,inf", "--out", "o.png"],
    ["compute", "FILE", "--field", "range", "--out", "o.npz", "--channel", "nothing=1:dB"],
]
BAD_INPUT = [
    ["info", "missing.laz"],
    ["info", "."],
    ["info", "TABLE"],
    ["compute", "BARE", "--field", "incidence", "--out", "o.npz"],
    ["compute", "BARE", "--field", "ndi", "--out", "o.npz"],
    ["leaves", "BARE", "--label-field", "x", "--out", "TABLE"],
    ["replay", "FILE", "--out", "replayed"],
]


@pytest.mark.parametrize(
    ("words", "code"),
    [(w, 2) for w in WRONG_USE] + [(w, 3) for w in BAD_INPUT],
    ids=lambda value: " ".join(value[:4]) if isinstance(value, list) else str(value),
)
def test_errors_are_one_sentence_with_the_right_code(
    words: list[str],
    code: int,
    leaves_file: Path,
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text("angle,value\nsome,text\n")
    Path("bare.xyz").write_text("0 0 1\n0 1 1\n1 0 1\n1 1 1.1\n")
    places = {"FILE": str(leaves_file), "TABLE": "table.csv", "BARE": "bare.xyz"}
    before = sorted(p.name for p in tmp_path.iterdir())
    assert run([places.get(word, word) for word in words]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("leafscope: ")
    assert len(captured.err.strip().splitlines()) == 1
    left = sorted(p.name for p in tmp_path.iterdir() if p.name != "replayed")
    assert left == before


def test_a_missing_position_names_the_option_that_gives_it(tmp_path: Path, capsys: Capture) -> None:
    bare = tmp_path / "bare.xyz"
    bare.write_text("0 0 1\n0 1 1\n1 0 1\n1 1 1.1\n")
    out = tmp_path / "o.csv"
    assert run(["compute", str(bare), "--field", "range", "--out", str(out)]) == 3
    assert "--origin" in capsys.readouterr().err
    assert (
        run(["compute", str(bare), "--field", "range", "--origin", "0,0,0", "--out", str(out)]) == 0
    )
    assert out.is_file()


def test_nothing_is_overwritten_unasked(leaves_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.npz"
    out.write_bytes(b"precious")
    words = ["compute", str(leaves_file), "--field", "range", "--out", str(out)]
    assert run(words) == 3
    assert out.read_bytes() == b"precious"
    assert run([*words, "--overwrite"]) == 0
    assert out.read_bytes() != b"precious"


def test_debug_shows_the_trace(capsys: Capture) -> None:
    assert run(["info", "missing.laz"], debug=True) == 3
    assert "Traceback" in capsys.readouterr().err


def test_a_polite_kill_cancels_with_code_4(leaves_file: Path, tmp_path: Path) -> None:
    table = tmp_path / "big.csv"
    line = "0.123456 1.123456 2.123456 0.5\n"
    table.write_text("x y z intensity\n" + line * 6_000_000)
    out = tmp_path / "o.npz"
    words = ["compute", str(table), "--field", "range", "--origin", "0,0,0", "--out", str(out)]
    process = subprocess.Popen([sys.executable, "-m", "app.cli", *words], stderr=subprocess.PIPE)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(1.5)
    process.terminate()
    _, err = process.communicate(timeout=5)
    assert process.returncode == 4
    assert b"Cancelled" in err
    assert not out.exists()


def test_a_report_is_not_overwritten_unasked(leaves_file: Path, tmp_path: Path) -> None:
    out, report = tmp_path / "o.npz", tmp_path / "report.json"
    report.write_text("precious")
    words = ["compute", str(leaves_file), "--field", "range", "--out", str(out)]
    assert run([*words, "--report", str(report)]) == 3
    assert report.read_text() == "precious"
    assert not out.exists()
    assert run([*words, "--report", str(report), "--overwrite"]) == 0
    assert json.loads(report.read_text())["computed"]["range"] > 0


def test_what_the_system_refuses_is_a_sentence(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "taken").write_text("")
    assert run(["replay", "s.leafscope", "--out", str(tmp_path / "taken")]) == 3
    assert run(["demo", "--out", str(tmp_path / "taken")]) == 3
    assert run(["x" * 5000]) in (2, 3)
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 3
    assert all(line.startswith("leafscope: ") for line in errors)


def test_a_fault_of_ours_is_a_sentence_too(
    leaves_file: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise KeyError("odd")

    monkeypatch.setattr("app.services.info.describe_opened", fail)
    assert run(["info", str(leaves_file)]) == 1
    error = capsys.readouterr().err
    assert "KeyError" in error
    assert "--debug" in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize("after", [0.05, 0.4, 1.2])
def test_ctrl_c_cancels_wherever_it_comes(leaves_file: Path, tmp_path: Path, after: float) -> None:
    out = tmp_path / "new" / "replayed"
    command = [sys.executable, "-m", "app.cli", "demo", "--out", str(out)]
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")},
    )
    time.sleep(after)
    os.killpg(process.pid, signal.SIGINT)  # a terminal signals the whole group
    _, err = process.communicate(timeout=60)
    if process.returncode == -signal.SIGINT or process.returncode == 130:
        assert after < 0.4, "only Python's own start may end without a sentence"
    else:
        assert process.returncode == 4
        assert err.decode().strip() == "leafscope: Cancelled."
    assert not out.parent.exists()


SWALLOWED = """\
import os, signal
from app.cli import console
console.cancel_on_signals()
class Dying:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        sum(range(10))
Dying()
"""


def test_a_cancel_that_python_swallows_is_noticed_at_the_next_report() -> None:
    report = "try: console.watch().report(0.5)\nexcept console.Cancelled: print('noticed')\n"
    ran = _run_python(SWALLOWED + report)
    assert ran.stderr == ""  # swallowed, and nobody is told of it
    assert (ran.returncode, ran.stdout) == (0, "noticed\n")


@pytest.mark.parametrize("second", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_what_the_first_did_not(second: signal.Signals) -> None:
    ran = _run_python(f"{SWALLOWED}os.kill(os.getpid(), {int(second)})\nprint('goes on')\n")
    assert (ran.returncode, ran.stdout) == (-second, "")


@pytest.mark.parametrize("words", ["--list --json", "--show leaf"])  # beyond a buffer, and within
def test_no_complaint_where_nobody_reads_on(words: str) -> None:
    command = [sys.executable, "-m", "app.cli", "simulate", *words.split()]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    with process.stderr as stream:
        assert stream.read() == b""
    assert process.wait(timeout=60) == 141  # as of a program that SIGPIPE ends


def _run_python(text: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=60, check=False
    )


def test_negative_coordinates_are_no_options(leaves_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.npz"
    assert (
        run(
            [
                "compute",
                str(leaves_file),
                "--field",
                "range",
                "--origin",
                "-1,-2.5,-3",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    with np.load(out) as written:
        expected = np.linalg.norm(written["xyz"] - (-1, -2.5, -3), axis=1)
        np.testing.assert_allclose(written["range"], expected)
    picture = tmp_path / "p.png"
    assert (
        run(
            [
                "snapshot",
                str(leaves_file),
                "--colour",
                "range",
                "--limits",
                "-1,1",
                "--size",
                "100x100",
                "--out",
                str(picture),
            ]
        )
        == 0
    )


def test_a_report_never_takes_the_place_of_the_result(leaves_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.npz"
    words = ["compute", str(leaves_file), "--field", "range", "--out", str(out), "--report"]
    assert run([*words, str(out)]) == 2
    assert run([*words, str(tmp_path / "nowhere" / "r.json")]) == 3
    assert list(tmp_path.iterdir()) == []


def test_the_field_leaf_finds_leaves(leaves_file: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "o.npz"
    report = answer(capsys, "compute", leaves_file, "--field", "leaf", "--out", out)
    assert any("Find" in note for note in report["warnings"])
    with np.load(out) as written:
        assert np.isfinite(written["leaf"]).sum() > 100


def test_seconds_of_delta_omega_hold_leaves_and_curve(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    report = answer(
        capsys, "compute", leaves_file, "--field", "delta_omega", "--out", tmp_path / "o.npz"
    )
    parts = report["parts"]["delta_omega"]
    assert {"ghost_score", "leaves and curve"} <= set(parts)
    assert report["seconds"]["delta_omega"] == pytest.approx(
        sum(value for name, value in parts.items() if "." not in name)
    )


def test_what_was_asked_for_is_not_called_done_for_you(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    report = answer(
        capsys,
        "compute",
        leaves_file,
        "--field",
        "range",
        "--origin",
        "0,0,1",
        "--radius",
        "0.006",
        "--out",
        tmp_path / "o.npz",
    )
    assert report["warnings"] == []
