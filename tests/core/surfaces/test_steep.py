"""Normals of steep faces by intensity, on a plane of which everything is known."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.mesh import lay_out, mesh_leaf
from app.core.neighbours.steps import Cells
from app.core.surfaces.rim import LOST, estimate_lost, list_rim
from app.core.surfaces.steep import turn_steep

ORIGIN = np.zeros(3)
STEP, SIDE = 4e-4, 60


def mesh_plane(tilt: float):
    """A disc of beams on a plane leaning to the side by `tilt`."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:SIDE, :SIDE])
    side, up = (SIDE / 2 - column) * STEP, (SIDE / 2 - row) * STEP
    beams = np.stack([np.ones(len(row)), side, up], axis=1)
    normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    xyz = beams * (2.0 * normal[0] / (beams @ normal))[:, None]
    on = np.hypot(side, up) < 25 * STEP
    xyz[~on] = beams[~on] * 3.0
    members = np.flatnonzero(on)
    cells = Cells(SIDE, SIDE, row, column)
    return mesh_leaf(lay_out(xyz, ORIGIN, cells), members, beam=(0.0, 0.0)), xyz, members


def test_steep_faces_take_the_angle_of_intensity():
    mesh, xyz, members = mesh_plane(np.deg2rad(70.0))
    omega = np.full(len(xyz), np.deg2rad(75.0))
    turned = turn_steep(mesh, xyz, members, ORIGIN, omega)
    assert np.allclose(turned.omega, np.deg2rad(75.0))
    beams = -mesh.vertices[mesh.faces].mean(axis=1)
    beams /= np.linalg.norm(beams, axis=1)[:, None]
    assert np.allclose((turned.normals * beams).sum(axis=1), np.cos(np.deg2rad(75.0)))
    # The side is the plane's: the normal leans in the plane of beam and old normal.
    assert np.abs(turned.normals[:, 2]).max() < 0.02
    assert (turned.normals[:, 1] < 0.0).all() == (turned.normals[0, 1] < 0.0)
    assert turned.area is mesh.area
    assert turned.vertices is mesh.vertices


def test_flat_faces_and_unknown_angles_stay():
    mesh, xyz, members = mesh_plane(np.deg2rad(40.0))
    turned = turn_steep(mesh, xyz, members, ORIGIN, np.full(len(xyz), 1.3))
    assert (turned.omega == mesh.omega).all()
    assert np.allclose(np.linalg.norm(turned.normals, axis=1), 1.0)
    mesh, xyz, members = mesh_plane(np.deg2rad(70.0))
    nothing = np.full(len(xyz), np.nan)
    assert (turn_steep(mesh, xyz, members, ORIGIN, nothing).omega == mesh.omega).all()
    one = nothing.copy()
    one[members[len(members) // 2]] = 1.4
    changed = turn_steep(mesh, xyz, members, ORIGIN, one).omega != mesh.omega
    assert 0 < changed.sum() < 100  # it speaks for its neighbours only


def test_rim_of_a_square():
    corners = np.array([[1.0, 0, 0], [1, 0.01, 0], [1, 0.01, 0.01], [1, 0, 0.01]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    length, cosine = list_rim(corners, faces, np.array([0.0, 1.2]))
    assert len(length) == 4
    assert length.sum() == pytest.approx(0.04, rel=1e-3)
    assert sorted(np.round(cosine, 6)) == sorted(np.round(np.cos([0, 0, 1.2, 1.2]), 6))


def test_only_steep_rims_may_be_lost():
    corners = np.array([[1.0, 0, 0], [1, 0.01, 0], [1, 0.01, 0.01], [1, 0, 0.01]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    level, steep = np.full(2, 0.9), np.full(2, 1.2)
    assert estimate_lost(corners, faces, level, 0.002) == 0.0
    wide = LOST * 0.002 * 0.04 * (1 / np.cos(1.2) - 1)
    assert estimate_lost(corners, faces, steep, 0.002) == pytest.approx(wide, rel=1e-3)
    edge_on = estimate_lost(corners, faces, np.full(2, np.pi / 2), 0.002)
    assert edge_on == pytest.approx(LOST * 0.002 * 0.04 * 19, rel=1e-3)


def test_an_edge_on_leaf_is_a_lower_bound():
    area = mesh_plane(np.deg2rad(75.0))[0].area
    assert area.steep
    assert not area.sure
    assert not mesh_plane(np.deg2rad(63.0))[0].area.steep
