"""Files of triangles."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from app.core.errors import BadInput, WrongUse
from app.formats.mesh_files import Part, write_parts


def make_parts(offset=0.0):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]], float) + offset
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    part = Part("Leaf 1", corners, faces, np.array([10.0, 20.0]))
    return [part, Part("Leaf\n2", corners + np.array([0, 0, 3]), faces[:1], np.array([30.0]))]


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl"])
def test_another_program_reads_them(tmp_path, suffix):
    path = tmp_path / f"leaves{suffix}"
    write_parts(path, make_parts())
    found = pv.read(path)
    assert found.n_cells == 3
    assert found.area == pytest.approx(0.5 + 0.5 * np.sqrt(1.5) + 0.5, rel=1e-6)


def test_ply_tells_leaf_and_angle(tmp_path):
    path = tmp_path / "leaves.ply"
    write_parts(path, make_parts())
    head, body = path.read_bytes().split(b"end_header\n")
    assert b"comment leaf 1: Leaf 2" in head
    row = np.dtype([("n", "u1"), ("v", "<i4", 3), ("leaf", "<i4"), ("omega", "<f4")])
    faces = np.frombuffer(body[8 * 24 :], row)
    assert faces["leaf"].tolist() == [0, 0, 1]
    assert faces["omega"].tolist() == [10.0, 20.0, 30.0]
    assert faces["v"][2].tolist() == [4, 5, 6]


def test_refusals_leave_nothing(tmp_path):
    with pytest.raises(WrongUse, match="End it with"):
        write_parts(tmp_path / "leaves.txt", make_parts())
    with pytest.raises(BadInput, match="no triangle"):
        write_parts(tmp_path / "leaves.ply", [])
    with pytest.raises(BadInput, match="too few digits"):
        write_parts(tmp_path / "leaves.stl", make_parts(5e5))
    (tmp_path / "old.ply").write_text("mine")
    with pytest.raises(BadInput, match="exists"):
        write_parts(tmp_path / "old.ply", make_parts())
    assert [p.name for p in tmp_path.iterdir()] == ["old.ply"]
