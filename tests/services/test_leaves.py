"""Leaves: found, named, measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.model.leaf import Leaf
from app.model.operations import PutLeaf, SetDeleted
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Scan
from app.services.curves import fit_leaves
from app.services.leaves import find_leaves, leaves_from_labels, measure_leaves, write_table
from app.services.opening import add_scans, set_parameters

KEY = "scan-00001"


def make_plate(left: float, right: float) -> np.ndarray:
    x, y = np.meshgrid(np.arange(left, right, 0.004), np.arange(0.0, 0.1, 0.004))
    return np.column_stack((x.ravel(), y.ravel(), np.ones(x.size)))


def open_scan(scan: Scan) -> Project:
    project = Project()
    add_scans(project, [scan])
    return project


def test_deleted_points_tie_nothing_together() -> None:
    parts = make_plate(0.0, 0.1), make_plate(0.1, 0.2), make_plate(0.2, 0.3)
    xyz = np.concatenate(parts)
    project = open_scan(Scan("plates", xyz))
    assert len(find_leaves(project, KEY)) == 1
    project.undo()
    bridge = np.arange(len(parts[0]), len(parts[0]) + len(parts[1]))
    project.do(SetDeleted(KEY, PointSet(bridge)))
    keys = find_leaves(project, KEY)
    sizes = [len(project.state.leaves[key].members) for key in keys]
    assert sizes == [len(parts[0]), len(parts[2])]


def test_a_missing_value_does_not_empty_the_index_of_means() -> None:
    values = {"a": np.array([3.0, 5.0, np.nan, 4.0]), "b": np.array([1.0, 1.0, 1.0, 1.0])}
    channels = (Channel("a", "a", 1063.0), Channel("b", "b", 1545.0))
    project = open_scan(Scan("s", np.random.default_rng(1).random((4, 3)), values, channels))
    project.do(PutLeaf("leaf-00001", Leaf("leaf-00001", KEY, "one", PointSet(range(4)))))
    (row,) = measure_leaves(project, KEY)
    assert row["a_mean"] == 4.0
    assert row["ndi_of_means"] == pytest.approx((4.0 - 1.0) / (4.0 + 1.0))


def test_a_leaf_is_measured_without_its_deleted_points(leaves: Scan) -> None:
    project = open_scan(leaves)
    keys = leaves_from_labels(project, KEY, "truth_leaf")
    members = project.state.leaves[keys[1]].members.indices
    project.do(SetDeleted(KEY, PointSet(members[::2])))
    row = measure_leaves(project, KEY)[1]
    kept = members[1::2]
    assert row["points"] == len(kept)
    expected = leaves.attributes["reflectance_1063"][kept].astype(float).mean()
    assert row["reflectance_1063_mean"] == pytest.approx(expected)


def test_a_new_leaf_never_inherits_the_fits_of_a_removed_one(leaves: Scan) -> None:
    project = open_scan(leaves)
    set_parameters(project, KEY, radius=0.02)
    keys = leaves_from_labels(project, KEY, "truth_leaf")
    fit_leaves(project, KEY, keys[-1:], "lambert")
    project.do(PutLeaf(keys[-1], None))
    again = leaves_from_labels(project, KEY, "truth_leaf")
    assert keys[-1] not in again


def test_fitting_a_leaf_that_is_gone_is_a_sentence(leaves: Scan) -> None:
    project = open_scan(leaves)
    leaves_from_labels(project, KEY, "truth_leaf")
    (other,) = add_scans(project, [leaves])
    with pytest.raises(WrongUse, match="no leaf-00099"):
        fit_leaves(project, KEY, ["leaf-00099"], "lambert")
    with pytest.raises(WrongUse, match="no leaf-00001"):
        fit_leaves(project, other, ["leaf-00001"], "lambert")


def test_leaves_that_are_known_are_not_found_again(leaves: Scan) -> None:
    project = Project()
    (key,) = add_scans(project, [leaves])
    everything = find_leaves(project, key)
    project.undo()
    first = np.flatnonzero(leaves.attributes["truth_leaf"] == 1)
    made = Leaf("leaf-00001", key, "mine", PointSet(first[: int(0.8 * len(first))]))
    project.do(PutLeaf(made.key, made))
    again = find_leaves(project, key)
    assert len(again) == len(everything) - 1
    others = [project.state.leaves[k].members for k in again]
    assert all(len(members & made.members) == 0 for members in others)


def test_without_rows_and_columns_the_same_leaves_are_found(leaves: Scan) -> None:
    found = []
    for scan in (leaves, replace(leaves, grid=None)):
        project = open_scan(scan)
        keys = find_leaves(project, KEY)
        found.append([project.state.leaves[key].members.indices for key in keys])
    assert len(found[0]) == len(found[1]) >= 5
    for one, other in zip(*found, strict=True):
        assert len(np.setxor1d(one, other)) < 0.02 * len(one)


def test_only_what_a_spreadsheet_would_run_gets_an_apostrophe(tmp_path: Path) -> None:
    rows = [{"leaf": "=1+1", "treatment": "", "label": "a", "angle_deg": -30.0}]
    write_table(rows, tmp_path / "leaves.csv")
    assert (tmp_path / "leaves.csv").read_text().splitlines()[1] == "'=1+1,,a,-30.0"
