"""Footprint against the check values of the paper."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.footprint import footprint_axis

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
