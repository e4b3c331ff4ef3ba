"""Triangles in the picture: where they are, in which colour, and that they go."""

from __future__ import annotations

import numpy as np
import pytest

from app.render.mesh_actor import HIGHEST, PALETTE, MeshActor
from app.render.palettes import colours
from app.render.stage import Stage

FAR = np.array([500_000.0, 5_400_000.0, 300.0])


def triangles() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]) + FAR
    return corners, np.array([[0, 1, 2], [0, 2, 3]]), np.array([10.0, 80.0])


def test_triangles_are_where_they_belong_in_the_colours_of_their_angles() -> None:
    mesh = MeshActor()
    corners, faces, omega = triangles()
    mesh.show(corners, faces, omega)
    mesh.place(FAR)
    data = mesh.actor.GetMapper().GetInput()
    offset = np.array(mesh.actor.GetPosition())
    drawn = np.array([data.GetPoint(k) for k in range(4)]) + offset + FAR
    assert drawn == pytest.approx(corners, abs=1e-6)
    assert mesh.bounds() == pytest.approx(np.stack([corners.min(0), corners.max(0)]))
    shown = [data.GetCellData().GetScalars().GetTuple(k) for k in range(2)]
    assert np.array_equal(shown, colours(omega, 0.0, HIGHEST, PALETTE))
    assert data.GetNumberOfPolys() == 2


def test_the_stage_takes_it_in_and_lets_it_go() -> None:
    stage = Stage()
    stage.drawings.show_mesh(triangles())
    assert any(box is not None for box in stage.drawings.bounds())
    assert stage.renderer.GetActors().GetNumberOfItems() == 1
    stage.drawings.show_mesh(None)
    assert stage.renderer.GetActors().GetNumberOfItems() == 0
    stage.drawings.show_mesh(triangles())
    stage.clear()
    assert stage.renderer.GetActors().GetNumberOfItems() == 0
    assert all(box is None for box in stage.drawings.bounds())
