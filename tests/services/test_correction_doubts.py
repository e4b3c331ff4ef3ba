"""Doubts about the numbers of a correction, and where they are told."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.formats.cloud import Cloud
from app.model.corrections import Correction
from app.model.operations import AddScan
from app.model.project import Project
from app.services.correction_doubts import doubt_correction
from app.services.export import export
from app.services.workflow_preview import Order, preview_workflows
from app.simulate.scenes import leaf_row_scan

NIR = "reflectance_1063"


@pytest.mark.parametrize(
    ("workflow", "values", "says"),
    [
        ("wf2", {"b": 1.7}, []),
        ("wf3", {"k_d": 0.7, "m": 0.3}, []),
        ("wf3", {"k_d": 0.7, "m": 0.7}, ["m is above 0.632"]),
        ("wf3", {"k_d": 0.7, "m": 1.0}, ["m is on its bound, 1:", "m is above 0.632"]),
        ("wf3", {"k_d": 0.0, "m": 0.3}, ["k_d is on its bound, 0:"]),
        ("wf3", {"k_d": 1.0}, ["k_d is 1"]),
        ("wf3_subtracted", {"f": 0.0, "k_d": 1.0, "m": 1.0}, ["k_d is 1"]),
    ],
)
def test_numbers_at_their_limits(workflow: str, values: dict[str, float], says: list[str]) -> None:
    found = doubt_correction(Correction("i", workflow, values))
    assert len(found) == len(says)
    assert all(text.startswith(start) for text, start in zip(found, says, strict=True))


@pytest.fixture(scope="module")
def rough(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Leaves whose values follow a term that no physical roughness gives."""
    scan = leaf_row_scan(step_deg=0.1)
    path = tmp_path_factory.mktemp("rough") / "rough.laz"
    angle = np.deg2rad(scan.attributes["truth_leaf"] * 15.0)
    t = np.tan(np.clip(angle, 0.0, 1.4)) ** 2
    term = np.exp(2.5 * np.log1p(t) - t / 0.8**2)
    scan.attributes[NIR] = (0.2 * np.cos(angle) + 0.2 * term).astype(np.float32)
    export(Cloud(scan), path)
    return path


def test_the_command_tells_doubts(
    rough: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wf.csv"
    words = ["correct", str(rough), "--out", str(out), "--channel", NIR, "--workflow", "wf3"]
    words += ["--label-field", "truth_leaf"]
    assert run(words) == 0
    assert "6 leaves, reflectance_1063, wf3: m is above 0.632" in capsys.readouterr().out
    with out.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["channel"] == NIR]
    assert len(rows) == 6
    assert all(row["wf3_words"].startswith("m is above 0.632") for row in rows)
    assert run([*words, "--overwrite", "--json"]) == 0
    assert "m is above 0.632" in json.loads(capsys.readouterr().out)["warnings"][0]


def test_the_preview_tells_doubts_of_typed_numbers() -> None:
    project = Project()
    key = project.shelve(leaf_row_scan(step_deg=0.2))
    project.do(AddScan(key, "row", None))
    order = Order((NIR,), ("wf3",), "typed", values={"k_d": 0.5, "m": 1.0})
    (said,) = preview_workflows(project, key, order).warnings
    assert said.startswith("reflectance_1063, wf3: m is on its bound, 1")


def test_no_fit_and_no_correction_is_refused(
    rough: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["correct", str(rough), "--out", str(tmp_path / "o.csv"), "--fit", "none"]
    words += ["--label-field", "truth_leaf"]
    assert run(words) == 2
    assert "--correct" in capsys.readouterr().err
    assert run([*words, "--correct", f"{NIR}:wf2:b=1.2"]) == 0
