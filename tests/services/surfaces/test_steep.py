"""Normals from intensity need a curve that is known beforehand, and come into the file."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.model.project import Project
from app.services.leaves import leaves_from_labels
from app.services.opening import Opening, add_scans
from app.services.surfaces.files import mesh_file
from app.services.surfaces.meshes import mesh_leaves
from app.services.surfaces.steep import choose_curve, turn_surfaces
from app.services.wrinkles.request import TableCurve


@pytest.fixture
def curve(tmp_path, leaves):
    """The mean curve of the scan's own leaves, by truth."""
    told = leaves.attributes
    channel = leaves.channels[0].name
    value = leaves.channel_values(channel)
    full = (told["truth_leaf"] >= 0) & (told["truth_hit_fraction"] > 0.99) & np.isfinite(value)
    lines = ["angle,value"]
    for low in range(0, 85, 5):
        here = full & (told["truth_incidence"] >= low) & (told["truth_incidence"] < low + 5)
        if here.sum() > 20:
            lines.append(f"{told['truth_incidence'][here].mean()},{np.median(value[here])}")
    path = tmp_path / "curve.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_without_a_curve_it_is_refused(leaves) -> None:
    with pytest.raises(WrongUse, match="known beforehand"):
        choose_curve(None)
    project = Project()
    (key,) = add_scans(project, [leaves])
    leaves_from_labels(project, key, "truth_leaf")
    with pytest.raises(WrongUse, match="Phase lab"):
        turn_surfaces(project, key, [])


def test_steep_faces_change_and_areas_do_not(leaves, curve) -> None:
    project = Project()
    (key,) = add_scans(project, [leaves])
    leaves_from_labels(project, key, "truth_leaf")
    before = mesh_leaves(project, key)
    after = turn_surfaces(project, key, before, TableCurve(curve))
    for one, other in zip(before, after, strict=True):
        assert (one.mesh is None) == (other.mesh is None)
        if one.mesh is not None:
            assert one.mesh.area == other.mesh.area
            changed = one.mesh.omega != other.mesh.omega
            assert (one.mesh.omega[changed] > np.pi / 3).all()
            assert other.mesh.normals.shape == (len(one.mesh.faces), 3)


def test_the_file_holds_the_normals(leaves_file, curve, tmp_path) -> None:
    out = tmp_path / "leaves.ply"
    mesh_file(Opening(leaves_file), out, "truth_leaf", steep=TableCurve(curve))
    assert b"property float nz" in out.read_bytes()[:4000]
    plain = tmp_path / "plain.ply"
    mesh_file(Opening(leaves_file), plain, "truth_leaf")
    assert b"property float nz" not in plain.read_bytes()[:4000]
