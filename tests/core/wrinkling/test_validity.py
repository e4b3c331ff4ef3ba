"""Angles from intensity: their error in parts, their interval, and why one is not valid."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.core.fitting import fit
from app.core.intensity_angle import Doubt
from app.core.phase import get_model
from app.core.wrinkling.curve import KnownCurve, curve_of_fit, curve_of_model
from app.core.wrinkling.offset import Offset, scatter_of
from app.core.wrinkling.validity import PARTS, Limits, invert_points, name_reasons

LAMBERT = curve_of_model(get_model("lambert"), {"f": 0.4})
LB = get_model("lambert-beckmann")
LEAF = curve_of_model(LB, {"f": 0.4, "k_d": 0.8, "m": 0.3})
DN = curve_of_model(LB, {"f": 0.4, "k_d": 0.8, "m": 0.3}, per_decade=600.0)


def lambert(degrees):
    return 0.4 * np.cos(np.deg2rad(np.asarray(degrees, float)))


@given(st.floats(1.0, 85.0))
def test_an_angle_comes_back_on_every_scale(degrees):
    angle = np.deg2rad([degrees])
    for curve in (LAMBERT, LEAF, DN):
        assert np.allclose(invert_points(curve.evaluate(angle), 0.0, curve).omega, angle, atol=1e-7)


def test_the_errors_of_a_species_are_those_of_the_issue():
    found = invert_points(
        lambert([20, 30, 45, 60]), 0.0, LAMBERT, scatter=scatter_of(0.08, "linear", None)
    )
    assert np.allclose(np.rad2deg(found.sigma), [13, 8, 5, 3], atol=0.7)
    assert np.allclose(found.sigma, 0.08 / np.tan(np.deg2rad([20, 30, 45, 60])))


def test_both_scales_give_the_same_error_for_the_same_scatter():
    angle = np.deg2rad([25.0, 40.0, 55.0])
    linear = invert_points(
        LEAF.evaluate(angle), 0.0, LEAF, scatter=scatter_of(0.08, "linear", None)
    )
    log = invert_points(DN.evaluate(angle), 0.0, DN, scatter=scatter_of(0.08, "log", 600.0))
    assert np.allclose(linear.sigma, log.sigma)


def test_parts_can_be_told_apart_and_add_up():
    angle = np.deg2rad(np.arange(0, 85, 5.0))
    random = np.random.default_rng(1)
    result = fit("lambert", angle, lambert(np.rad2deg(angle)) + 0.01 * random.normal(size=17))
    curve = curve_of_fit(result, "linear")
    offset, scatter = Offset("factor", 1.1, 0.05), scatter_of(0.08, "linear", None)
    found = invert_points(1.1 * lambert([40.0]), 0.02, curve, offset, scatter)
    at, slope = found.omega, np.abs(curve.slope(found.omega))
    value = curve.evaluate(at)
    assert tuple(found.parts) == PARTS
    assert np.allclose(found.parts["noise"], 0.02 / 1.1 / slope)
    sd = result.parameters["f"].sd
    assert np.allclose(found.parts["curve"], sd * np.cos(at) / slope)
    assert np.allclose(found.parts["reflectance"], 0.08 * value / slope)
    assert np.allclose(found.parts["offset"], value * 0.05 / 1.1 / slope)
    assert np.allclose(found.sigma**2, sum(part**2 for part in found.parts.values()))


def test_the_curve_error_is_that_of_repeated_tables():
    angle, random = np.deg2rad(np.arange(0, 85, 5.0)), np.random.default_rng(2)
    true = LEAF.evaluate(angle)
    value, found = LEAF.evaluate(np.deg2rad([35.0])), []
    for _ in range(200):
        table = true * (1 + 0.02 * random.normal(size=len(angle)))
        found.append(curve_of_fit(fit(LB, angle, table), "linear"))
    spread = np.std([curve.invert(value)[0] for curve in found])
    told = np.median([invert_points(value, 0.0, curve).parts["curve"][0] for curve in found])
    assert told == pytest.approx(spread, rel=0.3)


def test_reasons():
    values = [np.nan, 0.5, *lambert([3.0, 40.0, 70.0])]
    found = invert_points(np.array(values), 0.005, LAMBERT)
    assert found.doubt.tolist() == [
        Doubt.MISSING, Doubt.OUTSIDE, Doubt.NONE, Doubt.NONE, Doubt.BEYOND,
    ]  # fmt: skip
    flat = invert_points(lambert([3.0]), 0.02, LAMBERT)
    assert flat.doubt.tolist() == [Doubt.FLAT]
    wide = invert_points(lambert([70.0]), 0.005, LAMBERT, limits=Limits(np.deg2rad(75.0)))
    assert wide.valid.all()
    marks = invert_points(
        lambert([40.0, 40.0]), 0.005, LAMBERT,
        saturated=np.array([True, False]), partial=np.array([True, True]),
    )  # fmt: skip
    assert marks.doubt.tolist() == [Doubt.SATURATED | Doubt.PARTIAL, Doubt.PARTIAL]
    counts = name_reasons(marks.doubt)
    assert counts["saturated"] == 1
    assert counts["beam only in part on the leaf"] == 1
    assert sum(counts.values()) == 2


def test_what_a_rising_part_has_too_is_ambiguous():
    rough = curve_of_model(LB, {"f": 0.4, "k_d": 0.2, "m": 0.9})
    low, high = rough.monotone
    assert low > np.deg2rad(10)
    assert rough.falls
    face_on = rough.evaluate(np.array([0.0]))[0]
    double = np.array([1.02 * face_on, 0.9 * face_on])
    doubt = invert_points(double, 0.0, rough, limits=Limits(high - 1e-6)).doubt
    assert (doubt & int(Doubt.AMBIGUOUS) != 0).tolist() == [True, False]


def test_the_interval_ends_at_face_on_and_holds_the_angle():
    found = invert_points(lambert([2.0, 30.0, 50.0]), 0.01, LAMBERT)
    assert found.low[0] == 0.0
    assert (found.low <= found.omega).all()
    assert (found.omega <= found.high).all()
    brighter = invert_points(np.array([0.405]), 0.01, LAMBERT)
    assert np.isnan(brighter.omega[0])
    assert brighter.low[0] == 0.0
    assert brighter.high[0] > 0.0


def test_the_interval_covers_68_percent():
    random = np.random.default_rng(3)
    true = np.deg2rad(random.uniform(5, 85, 40_000))
    values = LEAF.evaluate(true) * (1 + 0.08 * random.normal(size=len(true)))
    found = invert_points(values, 0.0, LEAF, scatter=scatter_of(0.08, "linear", None))
    held = (found.low <= true) & (true <= found.high)
    assert 0.66 < held[found.valid].mean() < 0.72


def test_refusals():
    with pytest.raises(BadInput, match="negative"):
        invert_points(lambert([40.0]), -0.1, LAMBERT)
    flat = KnownCurve(np.ones_like, np.zeros_like)
    with pytest.raises(BadInput, match="flat"):
        invert_points(lambert([40.0]), 0.0, flat)
    with pytest.raises(WrongUse):
        Limits(np.deg2rad(100.0))
    with pytest.raises(WrongUse):
        Limits(largest_sigma=0.0)
    with pytest.raises(WrongUse):
        curve_of_model(LB, {"f": 0.4, "k_d": 0.8, "m": 0.3}, per_decade=-1.0)
