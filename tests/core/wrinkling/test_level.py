"""The offset that makes a leaf agree with its plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput
from app.core.phase import get_model
from app.core.wrinkling.curve import curve_of_model
from app.core.wrinkling.level import level_leaf

VALUES = {"f": 0.4, "k_d": 0.8, "m": 0.3}
LINEAR = curve_of_model(get_model("lambert-beckmann"), VALUES)
DN = curve_of_model(get_model("lambert-beckmann"), VALUES, per_decade=600.0)
TILTS = np.deg2rad(np.linspace(25.0, 45.0, 200))


@given(st.floats(0.2, 5.0))
def test_a_known_offset_is_found_again(factor):
    linear = level_leaf(factor * LINEAR.evaluate(TILTS), LINEAR, TILTS.mean())
    assert linear.kind == "factor"
    assert linear.value == pytest.approx(factor, rel=1e-5)
    shift = 600 * np.log10(factor)
    log = level_leaf(DN.evaluate(TILTS) + shift, DN, TILTS.mean())
    assert log.kind == "added"
    assert log.value == pytest.approx(shift, abs=0.01)


def test_the_mean_angle_is_the_plane_s_whatever_the_shape():
    random = np.random.default_rng(1)
    tilts = np.deg2rad(np.clip(30 + 8 * random.gamma(2.0, 1.0, 500), 0, 80))
    offset = level_leaf(LINEAR.evaluate(tilts), LINEAR, np.deg2rad(35.0))
    mean = np.nanmean(LINEAR.invert(offset.remove(LINEAR.evaluate(tilts))))
    assert np.rad2deg(mean) == pytest.approx(35.0, abs=0.2)


def test_its_error_is_that_of_the_plane():
    sure = level_leaf(LINEAR.evaluate(TILTS), LINEAR, TILTS.mean(), 0.0)
    unsure = level_leaf(LINEAR.evaluate(TILTS), LINEAR, TILTS.mean(), np.deg2rad(2.0))
    here = np.array([TILTS.mean()])
    share = np.abs(LINEAR.slope(here) / LINEAR.evaluate(here))[0] * np.deg2rad(2.0)
    assert unsure.sigma == pytest.approx(np.hypot(share, sure.sigma), rel=1e-3)


@pytest.mark.parametrize("plane", [np.nan, np.deg2rad(70.0), 0.0])
def test_planes_that_tell_no_offset(plane):
    with pytest.raises(BadInput, match="plane"):
        level_leaf(LINEAR.evaluate(TILTS), LINEAR, plane)


def test_too_few_points():
    with pytest.raises(BadInput, match="nearer"):
        level_leaf(np.append(LINEAR.evaluate(TILTS[:9]), np.nan), LINEAR, TILTS.mean())
