"""Footprint against the check values of the paper."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.footprint import footprint_axis, leaf_diameter

LS880 = {"beam_radius": 0.0015, "half_divergence": np.deg2rad(0.014)}


@pytest.mark.parametrize(
    ("degrees", "mm"), [(0.0, 4.056), (65.0, 9.596), (85.0, 46.53), (79.33, 21.9)]
)
def test_ls880_at_2_16_m(degrees, mm):
    axis = footprint_axis(2.16, np.deg2rad(degrees), **LS880)
    assert float(axis) * 1000 == pytest.approx(mm, rel=5e-4)


def test_share_of_a_leaf_at_20_degrees():
    assert float(footprint_axis(2.16, np.deg2rad(20), **LS880)) / 0.0219 == pytest.approx(
        0.197, abs=5e-4
    )


@pytest.mark.parametrize(
    ("diameter", "full", "mm"), [(0.00225, 0.19e-3, 3.09), (0.003, 0.22e-3, 3.97)]
)
def test_spots_of_junttila_at_4_4_m(diameter, full, mm):
    axis = footprint_axis(4.4, 0.0, diameter / 2, full / 2)
    assert float(axis) * 1000 == pytest.approx(mm, abs=0.005)


def test_equals_the_beam_cut_by_a_plane():
    distance, angle, half, r0 = 3.0, 1.2, 0.002, 0.001
    slope = 1.0 / np.tan(angle)  # plane through (distance, 0): depth = distance + slope⁻¹·height
    ends = []
    for sign in (1, -1):
        # ray: height = sign·(r0 + x·tan δ), plane: x = distance + height / slope
        rise = sign * np.tan(half)
        height = sign * (r0 + distance * np.tan(half)) / (1 - rise / slope)
        ends.append(np.array([distance + height / slope, height]))
    assert float(footprint_axis(distance, angle, r0, half)) == pytest.approx(
        np.linalg.norm(ends[0] - ends[1]), rel=1e-9
    )


def test_grazing_missing_and_wrong():
    values = footprint_axis([2.0, 2.0, 2.0], [np.pi / 2, np.nan, 0.0], 0.001, 0.001)
    assert np.isinf(values[0])
    assert np.isnan(values[1])
    assert np.isfinite(values[2])
    with pytest.raises(WrongUse):
        footprint_axis(2.0, 0.0, -1.0, 0.0)


@pytest.mark.parametrize("tilt", [0.0, 0.7, np.pi / 2])
def test_a_disc_has_its_own_diameter(tilt):
    chance = np.random.default_rng(1)
    turn = chance.uniform(0.0, 2 * np.pi, 4000)
    far = 0.02 * np.sqrt(chance.uniform(0.0, 1.0, 4000))
    u, v = far * np.cos(turn), far * np.sin(turn)
    xyz = np.stack([u * np.cos(tilt), v, u * np.sin(tilt)], axis=1) + np.array([5.0, -3.0, 100.0])
    xyz[7] = np.nan
    normal = np.array([-np.sin(tilt), 0.0, np.cos(tilt)])
    assert leaf_diameter(xyz, normal) == pytest.approx(0.04, rel=0.01)


def test_a_rectangle_has_that_of_the_circle_with_its_area():
    u, v = (a.ravel() for a in np.mgrid[0:0.03:31j, 0:0.01:11j])
    xyz = np.stack([u, v, np.zeros(len(u))], axis=1)
    assert leaf_diameter(xyz, np.array([0.0, 0.0, 1.0])) == pytest.approx(
        2 * np.sqrt(0.03 * 0.01 / np.pi), rel=1e-9
    )


@pytest.mark.parametrize("points", [0, 2, 9])
def test_what_spans_no_area_has_no_diameter(points):
    along = np.linspace(0.0, 0.1, points)
    xyz = np.stack([along, along, np.zeros(points)], axis=1)
    assert np.isnan(leaf_diameter(xyz, np.array([0.0, 0.0, 1.0])))
