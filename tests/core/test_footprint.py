"""Footprint against the check values of the paper."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from app.core.errors import WrongUse
from app.core.footprint import footprint_axis, leaf_diameter

LS880 = {"beam_radius": 0.0015, "half_divergence": np.deg2rad(0.014)}


@pytest.mark.parametrize(
    ("degrees", "mm"), [(0.0, 4.056), (65.0, 9.596), (85.0, 46.53), (79.33, 21.9)]
)
def test_ls880_at_2_16_m(degrees, mm):
    axis = footprint_axis(2.16, np.deg2rad(degrees), **LS880)
    assert float(axis) * 1000 == pytest.approx(mm, rel=5e-4)


def test_check_values_to_all_their_digits():
    angle = np.deg2rad([0.0, 65.0, 85.0])
    assert np.round(footprint_axis(2.16, angle, **LS880) * 1000, 3).tolist() == [
        4.056,
        9.596,
        46.533,
    ]
    share = float(footprint_axis(2.16, np.deg2rad(20.0), **LS880)) / 0.0219
    assert share == pytest.approx(0.1971, rel=2e-4)
    equal = brentq(lambda w: float(footprint_axis(2.16, w, **LS880)) - 0.0219, 1.0, 1.5)
    assert np.rad2deg(equal) == pytest.approx(79.33, rel=1e-4)


@pytest.mark.parametrize("degrees", [0.0, 40.0, 89.0])
def test_a_beam_that_does_not_widen_is_cut_as_a_cylinder(degrees):
    angle = np.deg2rad(degrees)
    wanted = 0.003 / np.cos(angle)
    assert float(footprint_axis(2.16, angle, 0.0015, 0.0)) == pytest.approx(wanted, rel=1e-12)
    narrow = [float(footprint_axis(2.16, angle, 0.0015, half)) for half in (1e-6, 1e-9, 1e-12)]
    assert np.abs(np.array(narrow) - wanted).argmin() == 2
    assert narrow[2] == pytest.approx(wanted, rel=1e-8)


def test_at_the_aperture_it_is_the_beam_itself():
    assert float(footprint_axis(0.0, 0.0, **LS880)) == pytest.approx(0.003, rel=1e-12)
    near = footprint_axis([0.0, 1e-12, 1e-6], np.deg2rad(70.0), **LS880)
    assert near == pytest.approx(near[0], rel=1e-6)
    assert float(footprint_axis(0.0, 0.5, 0.0, 1e-3)) == 0.0


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_it_grows_without_bound_where_the_outer_ray_grazes(gap):
    half = LS880["half_divergence"]
    angle = np.pi / 2 - half - gap  # tan ω tan δ → 1
    # 1 - tan²ω tan²δ = cos(ω + δ) cos(ω - δ) / (cos²ω cos²δ), and cos(ω + δ) = sin of the gap.
    beam = 2 * (0.0015 + 2.16 * np.tan(half))
    wanted = beam * np.cos(angle) * np.cos(half) ** 2 / (np.sin(gap) * np.cos(angle - half))
    assert float(footprint_axis(2.16, angle, **LS880)) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("beyond", [0.0, 1e-9, 1e-4])
def test_beyond_it_there_is_no_end(beyond):
    for half in (0.0, LS880["half_divergence"]):
        angle = np.pi / 2 - half + beyond
        assert float(footprint_axis(2.16, angle, 0.0015, half)) == np.inf


def test_an_unknown_or_negative_distance_has_none():
    angle = np.deg2rad([30.0, 90.0, 30.0])
    assert np.isnan(footprint_axis([np.nan, np.nan, -1.0], angle, **LS880)).all()


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
