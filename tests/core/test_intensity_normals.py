"""Normals from intensity."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.incidence import incidence_angle
from app.core.intensity_normals import cone_normals


def test_normals_have_the_angle_and_lie_in_the_plane_of_beam_and_normal():
    rng = np.random.default_rng(1)
    xyz, plane = rng.normal(size=(50, 3)) + 5.0, rng.normal(size=(50, 3))
    omega = rng.uniform(0.0, np.pi / 2, 50)
    found = cone_normals(xyz, np.zeros(3), plane, omega)
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0)
    assert np.allclose(incidence_angle(xyz, found, np.zeros(3)), omega)
    assert np.abs(np.linalg.det(np.stack([found, plane, xyz], axis=1))).max() < 1e-9


def test_the_planes_own_angle_gives_its_normal():
    rng = np.random.default_rng(2)
    xyz, plane = rng.normal(size=(50, 3)) + 5.0, rng.normal(size=(50, 3))
    plane /= np.linalg.norm(plane, axis=1)[:, None]
    omega = incidence_angle(xyz, plane, np.zeros(3))
    found = cone_normals(xyz, np.zeros(3), plane, omega)
    assert np.allclose(np.abs((found * plane).sum(axis=1)), 1.0)
    assert ((found * -xyz).sum(axis=1) >= -1e-12).all()


def test_unknown_stays_unknown():
    xyz = np.array([[2.0, 0, 0]] * 4)
    plane = np.array([[1.0, 0, 0], [1.0, 0, 0], [1.0, 1.0, 0], [np.nan, 0, 0]])
    found = cone_normals(xyz, np.zeros(3), plane, np.array([0.3, 0.0, np.nan, 0.3]))
    assert np.isnan(found[[0, 2, 3]]).all()
    assert np.allclose(found[1], [-1.0, 0.0, 0.0])


def test_arrays_must_belong_together():
    with pytest.raises(WrongUse):
        cone_normals(np.ones((3, 3)), np.zeros(3), np.ones(3), np.ones(2))
