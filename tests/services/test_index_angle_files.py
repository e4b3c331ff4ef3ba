"""Index against angle: Hancock's table from known curves, and leaves of a simulated scan."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.core.errors import BadInput, MissingChannel, WrongUse
from app.core.phase import get_model
from app.formats.cloud import Cloud
from app.model.operations import AddScan
from app.model.project import Project
from app.services.export import export
from app.services.index_angle import compare_angles
from app.services.index_angle_files import (
    group_of_scan,
    index_angle_of_file,
    index_angle_of_table,
    join_groups,
)
from app.services.opening import Opening
from app.services.synthetic_footprints import index_in
from app.simulate.scenes import leaf_row_scan

ANGLES = np.arange(-60.0, 61.0, 10.0)
CHANNELS = ("nir=1063", "swir=1545")
LEAVES = {"euct1": (0.220, 0.025, 12.0), "beuc1": (0.396, 0.322, -20.0), "still": (0.2, 0.2, 5.0)}
"""A_1063, A_1545 and μ."""


def make_table(path: Path, noise: float = 0.0) -> Path:
    random = np.random.default_rng(6)
    cosine = get_model("cosine")
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["leaf", "holder", "nir", "swir"])
        for leaf, (near, short, mu) in LEAVES.items():
            for angle in ANGLES:
                values = (
                    cosine.evaluate(np.deg2rad(angle), {"A": A, "mu": mu, "nu": nu}).item()
                    for A, nu in ((near, 0.45), (short, 0.40))
                )
                table.writerow([leaf, angle, *(v + random.normal(0, noise) for v in values)])
    return path


def test_a_table_of_holder_angles_gives_the_amplitudes_of_its_curves(tmp_path: Path) -> None:
    path = make_table(tmp_path / "t.csv", 1e-6)
    found = index_angle_of_table(path, "ndi", "holder", CHANNELS, group=["leaf"])
    assert [row["leaf"] for row in found.rows] == list(LEAVES)
    fine = np.deg2rad(np.linspace(-60, 60, 2401))
    cosine = get_model("cosine")
    for row, (near, short, mu) in zip(found.rows, LEAVES.values(), strict=True):
        np.testing.assert_allclose(row["A_nir"], near, atol=1e-4)
        np.testing.assert_allclose(row["A_swir"], short, atol=1e-4)
        np.testing.assert_allclose(row["mu_deg"], mu, atol=0.01)
        a = cosine.evaluate(fine, {"A": near, "mu": mu, "nu": 0.45})
        b = cosine.evaluate(fine, {"A": short, "mu": mu, "nu": 0.40})
        index = (a - b) / (a + b)
        np.testing.assert_allclose(row["fitted_min"], index.min(), atol=1e-4)
        np.testing.assert_allclose(row["fitted_max"], index.max(), atol=1e-4)
        np.testing.assert_allclose(row["index_mean"], index[::200].mean(), atol=1e-4)
        assert row["measured_min"] >= index.min() - 1e-4
    assert found.rows[0]["A_exceeds_noise"] == 1


def test_noise_is_told_from_a_swing(tmp_path: Path) -> None:
    found = index_angle_of_table(
        make_table(tmp_path / "t.csv", 0.02), "ndi", "holder", CHANNELS, group=["leaf"]
    )
    by_leaf = {row["leaf"]: row for row in found.rows}
    assert by_leaf["euct1"]["A_exceeds_noise"] == 1
    assert by_leaf["still"]["A_nir_exceeds_noise"] == 1
    assert by_leaf["still"]["A"] < 6 * by_leaf["still"]["A_from_noise"]


def test_bad_tables_are_refused(tmp_path: Path) -> None:
    path = make_table(tmp_path / "t.csv")
    with pytest.raises(WrongUse, match="no wavelength"):
        index_angle_of_table(path, "ndi", "holder", ["nir", "swir=1545"])
    with pytest.raises(MissingChannel):
        index_angle_of_table(path, "wi", "holder", CHANNELS)
    with pytest.raises(BadInput, match="no column"):
        index_angle_of_table(path, "ndi", "theta", CHANNELS)


def test_leaves_of_a_scan_give_the_curve_of_their_material(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "row.laz"
    export(Cloud(leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2)), path)
    found = index_angle_of_file(
        Opening(path), "ndi", label_field="truth_leaf", together=True, model="lambert-beckmann"
    )
    model = get_model("lambert-beckmann")
    for line in found.curves:
        angle = np.deg2rad(line["angle_deg"])
        a = model.evaluate(angle, {"f": 0.48, "k_d": 0.88, "m": 0.22})
        b = model.evaluate(angle, {"f": 0.27, "k_d": 0.72, "m": 0.30})
        # Steep leaves are all rim at this step: their means hold mixed points.
        if line["angle_deg"] > 65:
            continue
        tolerance = 0.02 if line["curve"] == "fitted" else 0.05
        assert abs(line["index"] - (a - b) / (a + b)) < tolerance, line
    assert found.rows[0]["leaf"] == "all"
    assert found.rows[0]["mu_deg"] == 0.0
    single = index_angle_of_file(Opening(path), "ndi", label_field="truth_leaf")
    assert len(single.rows) == 6
    out, curve = tmp_path / "i.csv", tmp_path / "c.csv"
    words = ["index-angle", str(path), "--index", "ndi", "--out", str(out), "--curve", str(curve)]
    assert run([*words, "--label-field", "truth_leaf", "--together", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"][0]["index_mean"] == found.rows[0]["index_mean"]
    assert len(curve.read_text().splitlines()) == len(told["curves"]) + 1
    assert run(words) == 3  # the files exist


def test_the_command_takes_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = make_table(tmp_path / "t.csv", 0.001), tmp_path / "i.csv"
    words = ["index-angle", str(path), "--angle", "holder", "--group", "leaf", "--out", str(out)]
    index = "(r1063 - r1550) / (r1063 + r1550)"
    assert run([*words, "--index", index, "--channel", "nir=1063", "--channel", "swir=1545"]) == 0
    said = capsys.readouterr().out
    assert "5 nm off" in said
    assert "exceeds noise" in said
    assert run([*words, "--index", "ndi", "--overwrite"]) == 2  # no channels


def test_points_without_an_angle_or_beyond_80_degrees_are_counted() -> None:
    project = Project()
    key = project.shelve(leaf_row_scan(step_deg=0.06, noise_m=0.0004, seed=2))
    project.do(AddScan(key, "row", None))
    index = index_in(project, key, "ndi")
    points = np.flatnonzero(project.state.scan(key).alive)
    angle = project.field(key, "incidence", points)
    group = group_of_scan(project, key, index)
    assert group.beyond == np.count_nonzero(angle > 80.0) > 0
    assert group.without_angle == np.count_nonzero(np.isnan(angle)) > 0
    assert len(group.angle) + group.beyond + group.without_angle == len(points)
    both = join_groups([group, group])
    assert (both.beyond, both.without_angle) == (2 * group.beyond, 2 * group.without_angle)
    found = compare_angles(index, [group], "fourier-2", None, holder=False)
    assert found.rows[0]["beyond_80"] == group.beyond
    assert found.rows[0]["without_angle"] == group.without_angle
    left = f"{group.without_angle:,} without an angle, {group.beyond:,} beyond 80°"
    assert f"whole scan: points left out: {left}" in found.warnings[0]
