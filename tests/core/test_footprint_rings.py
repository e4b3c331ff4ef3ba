"""Rings against Balduzzi's equation 4 and the cone that they lie on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from app.core.errors import WrongUse
from app.core.footprint import footprint_axis
from app.core.footprint_rings import footprint_rings

RADIUS, HALF = 0.0015, np.deg2rad(0.4)  # wide, so that its parts can be told
SCANNER = np.array([1.0, -2.0, 0.5])


def place(random: np.random.Generator, degrees: float) -> tuple[np.ndarray, np.ndarray, float]:
    """A point, a normal at that angle to its beam, and the range."""
    beam = random.normal(size=3)
    beam /= np.linalg.norm(beam)
    distance = random.uniform(1.0, 8.0)
    side = np.cross(beam, random.normal(size=3))
    side /= np.linalg.norm(side)
    angle = np.deg2rad(degrees)
    return SCANNER + distance * beam, -np.cos(angle) * beam + np.sin(angle) * side, distance


@pytest.mark.parametrize("degrees", [0.0, 30.0, 65.0, 85.0])
def test_the_longest_diameter_is_equation_4(degrees: float) -> None:
    xyz, normal, distance = place(np.random.default_rng(3), degrees)
    (ring,) = footprint_rings(xyz[None], normal[None], SCANNER, RADIUS, HALF, 1440)
    axis = footprint_axis(distance, np.deg2rad(degrees), RADIUS, HALF)
    assert pdist(ring).max() == pytest.approx(float(axis), rel=1e-4)
    assert np.abs((ring - xyz) @ normal).max() < 1e-12
    beam = (xyz - SCANNER) / distance
    along = (ring - SCANNER) @ beam
    across = np.linalg.norm(ring - SCANNER - along[:, None] * beam, axis=1)
    assert across == pytest.approx(RADIUS + along * np.tan(HALF), rel=1e-9)


def test_the_side_of_the_normal_changes_nothing() -> None:
    xyz, normal, _ = place(np.random.default_rng(4), 50.0)
    one = footprint_rings(xyz[None], normal[None], SCANNER, RADIUS, HALF)
    assert footprint_rings(xyz[None], -normal[None], SCANNER, RADIUS, HALF) == pytest.approx(one)


def test_what_is_unknown_or_not_met_has_no_ring() -> None:
    random = np.random.default_rng(5)
    xyz, normal, _ = place(random, 89.9)
    good, its, _ = place(random, 10.0)
    points = np.stack((xyz, good, good, np.full(3, np.nan), SCANNER))
    normals = np.stack((normal, its, np.full(3, np.nan), its, its))
    rings = footprint_rings(points, normals, SCANNER, RADIUS, HALF)
    known = np.isfinite(rings).all(axis=(1, 2))
    assert known.tolist() == [False, True, False, False, False]
    assert footprint_rings(np.empty((0, 3)), np.empty((0, 3)), SCANNER, 0.0, 0.0).shape[0] == 0
    with pytest.raises(WrongUse):
        footprint_rings(points, normals, SCANNER, -1.0, HALF)
