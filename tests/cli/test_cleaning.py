"""``leafscope clean``: settings, report, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.services.cleanup.answers import SETTINGS

Capture = pytest.CaptureFixture[str]


def clean(capsys: Capture, *args: object) -> dict:
    assert run(["clean", *map(str, args), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_settings_go_from_few_ghosts_to_many(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    found = {}
    for setting in ("careful", "normal", "strict"):
        out = tmp_path / f"{setting}.npz"
        found[setting] = clean(
            capsys, leaves_file, "--mode", "delete", "--setting", setting, "--out", out
        )
        assert found[setting]["threshold"] == SETTINGS[setting]
    counts = [found[setting]["ghosts"] for setting in SETTINGS]
    assert counts == sorted(counts)
    assert counts[0] < counts[2]
    own = clean(capsys, leaves_file, "--mode", "delete", "--threshold", "0.8", "--out",
                tmp_path / "own.npz")  # fmt: skip
    assert own["ghosts"] == counts[0]


def test_auto_corrects_what_is_sure_and_deletes_or_marks_the_rest(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out, report = tmp_path / "auto.npz", tmp_path / "auto.json"
    found = clean(capsys, leaves_file, "--mode", "auto", "--out", out, "--report", report)
    assert found["corrected"] + found["deleted"] == found["ghosts"]
    assert min(found["corrected"], found["deleted"]) > 0
    assert json.loads(report.read_text()) == found
    (scan,) = found["scans"]
    assert scan["method"] == "scan grid"
    assert sum(sum(counts.values()) for counts in scan["reasons"].values()) == found["ghosts"]
    assert scan["shift_median_mm"] <= scan["shift_95_mm"]
    with np.load(out) as written:
        assert len(written["xyz"]) == found["points"] - found["deleted"]
    left = clean(capsys, leaves_file, "--mode", "auto", "--uncertain", "mark", "--out",
                 tmp_path / "left.npz")  # fmt: skip
    assert (left["left_marked"], left["deleted"]) == (found["deleted"], 0)
    surer = clean(capsys, leaves_file, "--mode", "auto", "--sure", "0.95", "--out",
                  tmp_path / "surer.npz")  # fmt: skip
    assert surer["corrected"] < found["corrected"]


def test_marking_writes_why(leaves_file: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "marked.npz"
    found = clean(capsys, leaves_file, "--mode", "mark", "--out", out)
    with np.load(out) as written:
        ghost, reason = written["ghost"], written["ghost_reason"]
        score, confidence = written["ghost_score"], written["ghost_confidence"]
    assert ghost.sum() == found["ghosts"] == found["left_marked"]
    assert set(np.unique(reason[ghost])) <= set(map(float, found["reason_numbers"]))
    assert (score[ghost] >= found["threshold"]).all()
    assert np.isnan(confidence[~ghost]).all()
    assert ((confidence[ghost] >= 0) & (confidence[ghost] <= 1)).all()


def test_the_beam_is_said_and_people_can_read_it(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    args = ["clean", str(leaves_file), "--mode", "auto", "--instrument", "two_colour", "--out",
            str(tmp_path / "o.npz")]  # fmt: skip
    assert run(args) == 0
    said = capsys.readouterr().out
    for words in ("score: scan grid; threshold 0.5 (normal)", "instrument two_colour",
                  "between two surfaces: ", "corrected ghosts moved by"):  # fmt: skip
        assert words in said


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["--sure", "1.5"], "0 to 1"),
        (["--threshold", "2"], "0 to 1"),
        (["--report", "SAME"], "both the result and the report"),
        (["--setting", "wild"], "wild"),
    ],
)
def test_what_is_refused(
    leaves_file: Path, tmp_path: Path, capsys: Capture, extra: list[str], words: str
) -> None:
    out = tmp_path / "o.npz"
    extra = [str(out) if arg == "SAME" else arg for arg in extra]
    assert run(["clean", str(leaves_file), "--mode", "auto", "--out", str(out), *extra]) != 0
    said = capsys.readouterr()
    assert words in said.err + said.out
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("--mode", "delete", "--setting", "strict", "--threshold", "0.9"), "both name"),
        (("--mode", "delete", "--sure", "0.1"), "makes none"),
        (("--mode", "correct", "--uncertain", "mark"), "belongs to mode auto"),
    ],
)
def test_options_without_a_say_are_refused(
    leaves_file: Path, tmp_path: Path, capsys: Capture, options: tuple[str, ...], word: str
) -> None:
    out = tmp_path / "out.npz"
    assert run(["clean", str(leaves_file), *options, "--out", str(out)]) == 2
    assert word in capsys.readouterr().err
    assert not out.exists()
