"""Options of the angle: which there are, what they do, what is said of bad ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest

from app.cli import run
from app.cli.commands import Planes
from app.core.incidence import ESTIMATORS
from app.formats.cloud import Cloud
from app.model.scan import Scan
from app.services.export import export

Capture = pytest.CaptureFixture[str]


def compute(file: Path, out: Path, *words: str) -> dict[str, np.ndarray]:
    assert run(["compute", str(file), "--out", str(out), "--overwrite", *words], debug=True) == 0
    with np.load(out) as written:
        return dict(written)


def test_every_estimator_may_be_chosen() -> None:
    (choices, _) = get_args(get_type_hints(Planes)["estimator"])
    assert get_args(choices) == ESTIMATORS


def test_the_estimator_reaches_the_angle(leaves_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.npz"
    usual = compute(leaves_file, out, "--field", "incidence")["incidence"]
    ball = compute(leaves_file, out, "--field", "incidence", "--estimator", "ball")["incidence"]
    assert np.nanmedian(np.abs(usual - ball)) > 0.01


def test_the_beam_is_taken_as_given_or_as_the_scan_says(
    leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    out, words = tmp_path / "o.npz", ["--field", "footprint"]
    proposed = compute(leaves_file, out, *words)["footprint"]
    assert "as the scan says" in capsys.readouterr().out
    typed = ["--exit-diameter", "3", "--half-divergence", "0.014"]
    by_number = compute(leaves_file, out, *words, *typed)["footprint"]
    by_name = compute(leaves_file, out, *words, "--instrument", "ls880")["footprint"]
    np.testing.assert_allclose(by_number, by_name, rtol=1e-12)
    assert "(instrument ls880)" in capsys.readouterr().out
    wider = compute(leaves_file, out, *words, *typed[:3], "0.14")["footprint"]
    assert np.nanmin(wider / by_name) > 1.5
    assert np.isfinite(proposed).any()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--estimator", "octree"], "adaptive"),
        (["--instrument", "ls99"], "hds6100"),
        (["--exit-diameter", "3"], "--half-divergence"),
        (["--instrument", "ls880", "--half-divergence", "0.1"], "not by both"),
    ],
)
def test_bad_values_are_refused_in_a_sentence(
    leaves_file: Path, tmp_path: Path, capsys: Capture, words: list[str], says: str
) -> None:
    out = tmp_path / "o.npz"
    given = ["compute", str(leaves_file), "--field", "footprint", "--out", str(out), *words]
    assert run(given) == 2
    said = capsys.readouterr().err
    assert says in said
    assert len(said.strip().splitlines()) == 1
    assert not out.exists()


def test_info_says_how_neighbours_would_be_found(
    leaves: Scan, leaves_file: Path, tmp_path: Path, capsys: Capture
) -> None:
    assert run(["info", str(leaves_file), "--json"]) == 0
    (known,) = json.loads(capsys.readouterr().out)["neighbours"]
    assert known["method"] == "scan grid"
    assert known["step_deg"] == pytest.approx([0.05, 0.05], rel=0.02)
    bare = tmp_path / "bare.laz"
    export(Cloud(Scan("bare", leaves.xyz, pose=leaves.pose)), bare)
    assert run(["info", str(bare)]) == 0
    assert "neighbours: recovered grid, recovered from the directions" in capsys.readouterr().out
    export(Cloud(Scan("bare", leaves.xyz)), bare, True)
    assert run(["info", str(bare)]) == 0
    said = capsys.readouterr().out
    assert "neighbours: voxel hash, the scanner's position is unknown" in said


@pytest.mark.parametrize("command", ["leaves", "snapshot"])
def test_other_commands_take_an_estimator(leaves_file: Path, tmp_path: Path, command: str) -> None:
    words = {
        "leaves": ["--out", str(tmp_path / "o.csv")],
        "snapshot": ["--colour", "incidence", "--out", str(tmp_path / "o.png")],
    }
    assert run([command, str(leaves_file), *words[command], "--estimator", "window"]) == 0
