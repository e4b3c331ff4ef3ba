"""Reflectance with a mark for every point that has none."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from app.core.errors import LeafscopeError
from app.core.radiometry.budget import error_budget
from app.core.radiometry.drift import Power
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.marks import (
    BEYOND_RANGE,
    BEYOND_RESPONSE,
    DARK,
    GOOD,
    NO_SIGNAL,
    PARTIAL,
    SATURATED,
    WORDS,
    reflect,
)
from app.core.radiometry.profile import ChannelCalibration, Noise, Profile
from app.core.radiometry.range_curve import PolynomialCurve
from app.core.radiometry.salca import SalcaResponse

CURVE = PolynomialCurve("additive", (1.0, 3.56, 10.0), (30.0, 0.0, -200.0), 3.56)
LS880 = ChannelCalibration(
    "intensity_785",
    (LogResponse(600.0, 1784.0), CURVE),
    wavelength_nm=785.0,
    dark=0.0,
    saturated=2047.0,
    nearest=1.0,
    farthest=10.0,
)


def test_each_cause_has_its_mark() -> None:
    number = np.array([1500.0, np.nan, 0.0, 2047.0, 1500.0, 1500.0, 1500.0, np.nan])
    distance = np.array([3.56, 3.56, 3.56, 3.56, 0.9, 10.1, np.nan, 50.0])
    partial = np.zeros(8, bool)
    values, marks = reflect(LS880, number, distance, partial=partial)
    wanted = [GOOD, NO_SIGNAL, DARK, SATURATED, *[BEYOND_RANGE] * 3, NO_SIGNAL]
    assert marks.tolist() == wanted
    assert np.isfinite(values).tolist() == [mark == GOOD for mark in wanted]
    assert values[0] == pytest.approx(10 ** ((1500 - 1784) / 600))
    assert len(WORDS) == PARTIAL + 1


def test_a_margin_takes_the_effect_as_at_its_end() -> None:
    near = replace(LS880, nearest=0.92, farthest=10.1)
    values, marks = reflect(near, np.full(4, 1500.0), np.array([0.95, 1.0, 10.05, 10.6]))
    assert marks.tolist() == [GOOD, GOOD, GOOD, BEYOND_RANGE]
    assert values[0] == values[1]
    assert values[2] == reflect(LS880, np.full(1, 1500.0), np.array([10.0]))[0][0]
    sure = replace(near, noise=Noise(2.0), fit_covariance=((0.0,) * 4,) * 4,
                   panel_covariance=((0.0,) * 4,) * 4)  # fmt: skip
    budget = error_budget(sure, values, np.full(4, 1500.0), np.array([0.95, 1.0, 10.05, 10.6]))
    assert np.isfinite(budget.sigma).tolist() == [True, True, True, False]


def test_partial_hits_are_left_out_only_when_asked() -> None:
    number, distance = np.full(2, 1500.0), np.full(2, 4.0)
    partial = np.array([False, True])
    assert reflect(LS880, number, distance, partial=partial)[1].tolist() == [GOOD, PARTIAL]
    assert reflect(LS880, number, distance)[1].tolist() == [GOOD, GOOD]


def test_a_number_that_the_response_cannot_give_is_marked() -> None:
    salca = ChannelCalibration("intensity_1545", (Power(), SalcaResponse(137.21, 407.04, 16.83)))
    values, marks = reflect(salca, np.array([-3.0, 300.0]), np.ones(2), power=0.5)
    assert marks.tolist() == [BEYOND_RESPONSE, GOOD]
    full = reflect(salca, np.array([300.0]), np.ones(1))[0]
    assert values[1] == pytest.approx(2 * full[0])


def test_fields_are_named_by_what_they_hold() -> None:
    assert (LS880.name, LS880.kind) == ("reflectance_785", "reflectance")
    shift = ChannelCalibration("intensity_785", (CURVE,), wavelength_nm=785.0)
    assert (shift.name, shift.kind) == ("corrected_785", "DN")
    riegl = ChannelCalibration("Reflectance", (Decibel(),))
    assert riegl.name == "reflectance_linear"


@pytest.mark.parametrize(
    "make",
    [
        lambda: Profile("empty", ()),
        lambda: Profile("twice", (LS880, LS880)),
        lambda: ChannelCalibration("x", ()),
        lambda: ChannelCalibration("x", (CURVE,), wavelength_nm=-1.0),
        lambda: ChannelCalibration("x", (CURVE,), fit_covariance=((1.0,),)),
        lambda: ChannelCalibration("x", (CURVE,), range_sigma=-1.0),
        lambda: ChannelCalibration("x", (CURVE,), nearest=0.5),
        lambda: ChannelCalibration("x", (CURVE,), farthest=500.0),
        lambda: Noise(-1.0),
    ],
)
def test_impossible_profiles_are_refused_in_a_sentence(make) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(LeafscopeError, match=r"\w+ .+\."):
        make()
