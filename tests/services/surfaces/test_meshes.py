"""Meshes and areas of the leaves of a scan."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput, WrongUse
from app.model.operations import SetDeleted
from app.model.parameters import Beam
from app.model.points import PointSet
from app.model.project import Project
from app.model.scan import Channel, Pose, Scan
from app.services.leaf_tables import tabulate_leaves
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, add_scans, set_parameters
from app.services.surfaces.echoes import find_echo
from app.services.surfaces.files import mesh_file
from app.services.surfaces.meshes import COLUMNS, measure_areas, mesh_leaves, tell_area


def _size(leaf):
    return len(leaf.members)


@pytest.fixture
def project(leaves):
    made = Project()
    (key,) = add_scans(made, [leaves])
    leaves_from_labels(made, key, "truth_leaf")
    return made, key


def test_all_leaves_have_a_mesh_or_a_reason(project):
    made, key = project
    set_parameters(made, key, beam=Beam(0.0015, 0.0002, "typed in"))
    surfaces = mesh_leaves(made, key)
    assert len(surfaces) == len(made.state.leaves_of(key))
    told = [tell_area(surface) for surface in surfaces]
    assert all(set(row) == set(COLUMNS) for row in told)
    meshed = [row for row in told if row["area_cm2"] is not None]
    assert len(meshed) >= 4
    for row in meshed:
        assert 0 <= row["area_low_cm2"] <= row["area_cm2"]
        if "edge-on" in row["area_of"]:
            assert row["area_high_cm2"] is None
        else:
            assert row["area_cm2"] <= row["area_high_cm2"] < 100
        assert row["beam"] == "known"


def test_deleted_points_belong_to_no_mesh(project):
    made, key = project
    leaf = max(made.state.leaves_of(key), key=_size)
    before = mesh_leaves(made, key, [leaf.key])[0].mesh.area.value
    half = PointSet(leaf.members.indices[: len(leaf.members) // 2])
    made.do(SetDeleted(key, half, True))
    after = mesh_leaves(made, key, [leaf.key])[0]
    assert after.mesh is None or after.mesh.area.value < before
    made.do(SetDeleted(key, leaf.members, True))
    gone = mesh_leaves(made, key, [leaf.key])[0]
    assert gone.mesh is None
    assert "no surface" in gone.reason


def test_without_rows_and_columns_the_table_says_why():
    made = Project()
    xyz = np.random.default_rng(1).normal(size=(300, 3)) * 0.02 + [2.0, 0.0, 0.0]
    (key,) = add_scans(made, [Scan("cloud", xyz, {"label": np.zeros(300)})])
    leaves_from_labels(made, key, "label")
    told = measure_areas(made, key, made.state.leaves_of(key))
    (row,) = told.values()
    assert row["area_cm2"] is None
    assert "scanner's position" in row["area_of"]


@pytest.mark.parametrize(
    ("kind", "values", "factor"),
    [("linear", 5.0, 1.0), ("reflectance", 0.5, 0.25), ("DN", 0.5, 0.25), ("DN", 900.0, None)],
)
def test_echo_by_the_kind_of_channel(kind, values, factor):
    channel = Channel("i", "i", None, kind)
    scan = Scan(
        "s", np.array([[2.0, 0, 0]]), {"i": np.array([values])}, (channel,), Pose((0.0, 0.0, 0.0))
    )
    echo, scaled = find_echo(scan)
    assert scaled == (factor == 0.25)
    if factor is None:
        assert echo is None
    else:
        assert echo[0] == pytest.approx(values * factor)


def test_files_and_table(leaves_file, tmp_path):
    out = tmp_path / "leaves.ply"
    rows = mesh_file(Opening(leaves_file), out, "truth_leaf")
    assert out.read_bytes().startswith(b"ply\n")
    assert any(row["faces"] for row in rows)
    table = tabulate_leaves(Opening(leaves_file), tmp_path / "leaves.csv", "truth_leaf")
    assert set(COLUMNS) <= set(table[0])
    with pytest.raises(WrongUse, match="triangles"):
        mesh_file(Opening(leaves_file), tmp_path / "leaves.txt")
    with pytest.raises(BadInput, match="No mesh"):
        mesh_file(Opening(leaves_file), tmp_path / "none.ply", "truth_leaf", ("nobody",))
    assert not (tmp_path / "none.ply").exists()
