"""Corrections from fits against the simulator's truth; the table side by side; the command."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.core.errors import BadInput, WrongUse
from app.formats.cloud import Cloud
from app.model.operations import AddScan, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Scan
from app.services.correction_texts import parse_correction, use_correction_texts
from app.services.corrections import apply_corrections, correction_of_fit, remove_corrections
from app.services.curves import fit_leaves
from app.services.export import export
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening
from app.services.workflow_table import (
    Wanted,
    compare_workflows,
    correct_leaves,
    tabulate_workflows,
)
from app.simulate.scenes import leaf_row_scan

NIR, SWIR = "reflectance_1063", "reflectance_1545"
DIFFUSE = {NIR: 0.48 * 0.88, SWIR: 0.27 * 0.72}
"""f·k_d of the simulated leaves."""


@pytest.fixture(scope="module")
def row() -> Scan:
    """Flat leaves of one glossy material at 0, 15 … 75°, with noise."""
    return leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2)


@pytest.fixture(scope="module")
def row_file(row: Scan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scan") / "row.laz"
    export(Cloud(row), path)
    return path


@pytest.fixture
def opened(row: Scan) -> tuple[Project, str]:
    project = Project()
    key = project.shelve(row)
    project.do(AddScan(key, row.name, None))
    leaves_from_labels(project, key, "truth_leaf")
    return project, key


def test_wf3_of_one_fit_gives_the_diffuse_reflectance_of_every_leaf() -> None:
    project = Project()
    key = project.shelve(leaf_row_scan(step_deg=0.05))
    project.do(AddScan(key, "exact", None))
    scan = project.state.scan(key).scan
    rim = np.flatnonzero(~(scan.attributes["truth_hit_fraction"] > 0.999))
    project.do(SetDeleted(key, PointSet(rim)))
    leaves_from_labels(project, key, "truth_leaf")
    assert correct_leaves(project, key, Wanted()) == []
    for channel, truth in DIFFUSE.items():
        for leaf in project.state.leaves_of(key)[:5]:  # 0 to 60°
            value = project.field(key, f"{channel}_wf3", leaf.members.indices)
            np.testing.assert_allclose(np.nanmean(value), truth, rtol=0.01)
        tilted = project.field(key, channel, leaf.members.indices)
        assert np.nanmean(tilted) < 0.7 * truth


def test_the_fit_says_numbers_range_and_origin(opened: tuple[Project, str]) -> None:
    project, key = opened
    leaves = tuple(leaf.key for leaf in project.state.leaves_of(key))[1:3]
    record = fit_leaves(project, key, leaves, "incidence-b", NIR)
    made = correction_of_fit(project, record, "wf2")
    assert made.values == {"b": record.result["parameters"]["b"]["value"]}
    np.testing.assert_allclose(
        made.covariance["b"]["b"], record.result["parameters"]["b"]["sd"] ** 2, rtol=1e-9
    )
    assert made.fitted == tuple(record.result["angle_range"])
    assert made.leaves == leaves
    assert made.origin.startswith("fit of truth_leaf")
    assert correction_of_fit(project, record, "wf2", leaves=()).leaves == ()
    with pytest.raises(WrongUse, match="lambert-beckmann"):
        correction_of_fit(project, record, "wf3")
    steps = len(project.history.done)
    apply_corrections(project, key, [made])
    assert len(project.history.done) == steps + 1
    remove_corrections(project, key)
    assert project.state.scan(key).parameters.corrections == ()
    project.undo()
    assert project.state.scan(key).parameters.corrections == (made,)


def test_the_table_holds_what_the_fields_hold(opened: tuple[Project, str]) -> None:
    project, key = opened
    correct_leaves(project, key, Wanted((NIR,), ("wf2", "wf3_subtracted"), "all"))
    rows = compare_workflows(project, key)
    leaves = project.state.leaves_of(key)
    assert len(rows) == len(leaves) * 2
    for line in rows:
        members = next(leaf for leaf in leaves if leaf.key == line["leaf"]).members.indices
        name = str(line["channel"])
        for workflow in ("wf1", "wf2", "wf3_subtracted") if name == NIR else ("wf1",):
            field = name if workflow == "wf1" else f"{name}_{workflow}"
            value = project.field(key, field)[members]
            known = value[np.isfinite(value)]
            assert line[f"{workflow}_n"] == len(known)
            if workflow == "wf2":
                assert line["wf2_n"] + line["wf2_marked"] == len(members)
            np.testing.assert_allclose(line[f"{workflow}_mean"] or np.nan,
                                       known.mean() if len(known) else np.nan)  # fmt: skip
    assert "wf2_mean" not in rows[1]
    assert "b = " in str(rows[0]["wf2_by"])


@pytest.mark.parametrize(
    ("text", "values"),
    [
        (f"{NIR}:wf2:b=0.7,least=0.4,from=5,to=60", {"b": 0.7}),
        (f"{SWIR}:wf2:birch", {"b": 2.3}),
        (f"{SWIR}:wf3:lime", {"k_d": 0.6, "m": 0.49}),
        (f"{NIR}:wf3:k_d=1", {"k_d": 1.0}),
    ],
)
def test_texts_say_corrections(
    opened: tuple[Project, str], text: str, values: dict[str, float]
) -> None:
    project, key = opened
    found = parse_correction(project, key, text)
    assert found.values == values
    if "least" in text:
        assert found.least_bracket == 0.4
        np.testing.assert_allclose(np.rad2deg(found.fitted), (5, 60))
    use_correction_texts(project, key, [text])
    assert found.name in project.catalogue(key)


def test_a_table_of_fits_is_read(opened: tuple[Project, str], tmp_path: Path) -> None:
    project, key = opened
    fit = {"group": {"channel": NIR}, "model": "incidence-b", "n": 9, "rss": 0.1, "warnings": []}
    parameters = {"a": {"value": 1, "sd": 0.1}, "b": {"value": 0.7, "sd": 0.02}}
    path = tmp_path / "fits.json"
    path.write_text(json.dumps({"fits": [fit | {"parameters": parameters}]}))
    found = parse_correction(project, key, f"{NIR}:wf2:{path}")
    assert (found.values, found.covariance) == ({"b": 0.7}, {"b": {"b": 0.02**2}})
    with pytest.raises(BadInput, match="0 fits"):
        parse_correction(project, key, f"{SWIR}:wf2:{path}")
    with pytest.raises(BadInput, match="no table of fits"):
        parse_correction(project, key, f"{SWIR}:wf2:{tmp_path / 'no.json'}")


@pytest.mark.parametrize(
    "text",
    [
        "x",
        f"{NIR}:wf2",
        f"{NIR}:wf2:oak",
        f"{NIR}:wf9:b=1",
        f"{NIR}:wf2:birch",
        f"{NIR}:wf2:b=",
        f"{NIR}:wf2:b=nan",
    ],
)
def test_texts_that_say_none(opened: tuple[Project, str], text: str) -> None:
    with pytest.raises(WrongUse):
        parse_correction(*opened, text)


def test_the_commands_write_what_the_services_find(
    row_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, words = tmp_path / "table.csv", ["--label-field", "truth_leaf"]
    assert run(["correct", str(row_file), "--out", str(out), *words, "--workflow", "wf3"]) == 0
    assert "rows" in capsys.readouterr().out
    wanted = tabulate_workflows(
        Opening(row_file), tmp_path / "o.csv", Wanted(workflows=("wf3",)), label_field="truth_leaf"
    )
    with out.open() as file:
        lines = list(csv.DictReader(file))
    assert [float(line["wf3_mean"] or "nan") for line in lines] == pytest.approx(
        [float("nan") if r["wf3_mean"] is None else r["wf3_mean"] for r in wanted.rows], nan_ok=True
    )
    points = tmp_path / "points.npz"
    given = ["--correct", f"{NIR}:wf2:b=0.9", "--correct", f"{SWIR}:wf2:b=0.9"]
    given += ["--formula", "mine=r1063 / r1550", "--smooth", "20"]
    for field in ("ndi_wf2", f"{NIR}_wf2_sigma", f"{NIR}_wf2_mark", "mine", "ndi_smoothed"):
        given += ["--field", field]
    assert run(["compute", str(row_file), "--out", str(points), *given]) == 0
    said = capsys.readouterr().out
    assert "b = 0.9" in said
    assert "5 nm off" in said
    with np.load(points) as found:
        ratio = found[NIR] / found[SWIR]
        np.testing.assert_allclose(found["mine"][ratio > 0], ratio[ratio > 0], rtol=1e-6)
        assert np.nanstd(found["ndi_smoothed"]) < np.nanstd(found["ndi_wf2"])
    again = ["correct", str(row_file), "--out", str(out)]
    assert run(again) == 3
    assert run([*again, "--overwrite", "--workflow", "wf5"]) == 2
    assert run([*again, "--overwrite", "--fit", "x"]) == 2
