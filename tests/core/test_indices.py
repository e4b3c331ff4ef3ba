from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import MissingChannel
from app.core.formula import compile_formula
from app.core.indices import NAMED, evaluate, match_channels, warn_about_kinds

HSL = (564.3, 610.8, 659.9, 720.3, 764.8, 818.0, 878.6, 979.2)
HSL_OF_CHINA_ROSE = (555.0, 624.0, 691.0, 726.0, 760.0, 795.0, 899.0, 1000.0)


def named(wavelengths: tuple[float, ...]) -> dict[str, float | None]:
    return {f"c{nm:g}": nm for nm in wavelengths}


def test_the_five_indices_are_there() -> None:
    assert set(NAMED) == {"ndi", "ndvi", "wi", "lri", "nldi"}
    assert all(name == index.name and index.source for name, index in NAMED.items())


@pytest.mark.parametrize(
    ("name", "first", "second", "value"),
    [
        ("ndi", 0.5, 0.3, 0.25),
        ("ndvi", 0.45, 0.05, 0.8),
        ("wi", 0.48, 0.5, 0.96),
        ("lri", 0.2, 0.4, 0.5),
        ("nldi", 0.4, 0.2, 1 / 3),
    ],
)
def test_values_by_hand(name: str, first: float, second: float, value: float) -> None:
    index = NAMED[name]
    given = {index.roles[0]: np.array([first]), index.roles[1]: np.array([second])}
    assert evaluate(index, given)[0] == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("name", list(NAMED))
def test_the_printed_formula_is_the_one_computed(name: str) -> None:
    index = NAMED[name]
    rng = np.random.default_rng(1)
    given = {role: rng.uniform(0.01, 1.0, 50) for role in index.roles}
    by_text = compile_formula(index.formula, index.roles).evaluate(given)
    np.testing.assert_allclose(evaluate(index, given), by_text, rtol=1e-13)


numbers = st.floats(allow_nan=True, allow_infinity=True)


@given(st.sampled_from(sorted(NAMED)), numbers, numbers)
def test_never_infinite_and_undefined_without_light(name: str, a: float, b: float) -> None:
    index = NAMED[name]
    result = evaluate(index, {index.roles[0]: np.array([a]), index.roles[1]: np.array([b])})[0]
    assert not np.isinf(result)
    with np.errstate(all="ignore"):
        bottom = np.float64(a) + b if index.normalised else b
    if not bottom > 0:
        assert np.isnan(result)


def test_index_of_means_and_mean_of_indices_differ() -> None:
    near, far = np.array([0.5, 0.9]), np.array([0.4, 0.1])
    ndi = NAMED["ndi"]
    points = evaluate(ndi, {"r1063": near, "r1545": far})
    means = evaluate(ndi, {"r1063": near.mean(), "r1545": far.mean()})
    assert points.mean() == pytest.approx((1 / 9 + 0.8) / 2)
    assert means == pytest.approx((0.7 - 0.25) / 0.95)


@pytest.mark.parametrize(
    ("channels", "expected"),
    [
        (HSL, {"nir": "c818", "red": "c659.9"}),
        (HSL_OF_CHINA_ROSE, {"nir": "c795", "red": "c691"}),
    ],
)
def test_ndvi_takes_the_pair_of_its_instrument(
    channels: tuple[float, ...], expected: dict[str, str]
) -> None:
    assert match_channels(NAMED["ndvi"], named(channels)) == expected


def test_water_index_takes_the_nearest_channels() -> None:
    assert match_channels(NAMED["wi"], named(HSL)) == {"r900": "c878.6", "r970": "c979.2"}


def test_one_channel_between_both_wavelengths_is_not_used_twice() -> None:
    with pytest.raises(MissingChannel, match="cannot be both"):
        match_channels(NAMED["wi"], {"only": 935.0})


def test_first_of_equals_wins_and_unknown_wavelengths_are_left_out() -> None:
    there = {"id": None, "rho_a": 1064.0, "dn_a": 1064.0, "rho_b": 1545.0, "dn_b": 1545.0}
    assert match_channels(NAMED["ndi"], there) == {"r1063": "rho_a", "r1545": "rho_b"}


def test_missing_channel_says_what_is_missing_and_what_is_there() -> None:
    with pytest.raises(MissingChannel) as caught:
        match_channels(NAMED["ndi"], {"intensity": None, "reflectance_1063": 1063.0})
    sentence = str(caught.value)
    assert "1545 nm is missing" in sentence
    assert "1063 nm is missing" not in sentence
    assert "reflectance_1063 (1063 nm)" in sentence
    assert "intensity (wavelength unknown)" in sentence


def test_a_channel_beyond_the_tolerance_does_not_count() -> None:
    assert match_channels(NAMED["nldi"], {"a": 690.0, "b": 1545.0})["i1550"] == "b"
    with pytest.raises(MissingChannel):
        match_channels(NAMED["nldi"], {"a": 690.0 + 20.1, "b": 1550.0})


def test_no_warning_on_linear_scales() -> None:
    assert warn_about_kinds("ndi", {"a": "reflectance", "b": "reflectance"}) == ""
    assert warn_about_kinds("ndi", {"a": "linear", "b": "linear"}) == ""


@pytest.mark.parametrize(
    ("kinds", "words"),
    [
        ({"a": "dB", "b": "reflectance"}, "a in dB"),
        ({"a": "reflectance", "b": "DN"}, "b in raw DN"),
        ({"a": "linear", "b": "reflectance"}, "different scales"),
    ],
)
def test_a_warning_names_the_channel(kinds: dict[str, str], words: str) -> None:
    assert words in warn_about_kinds("ndi", kinds)
