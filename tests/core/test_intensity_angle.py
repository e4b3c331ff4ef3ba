from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.intensity_angle import Curve, Doubt, invert_intensity, sigma_omega


def arccos_or_nan(value: np.ndarray) -> np.ndarray:
    return np.where(np.abs(value) <= 1.0, np.arccos(np.clip(value, -1.0, 1.0)), np.nan)


def undefined_outside(angle: np.ndarray) -> np.ndarray:
    assert np.all(np.isnan(angle) | ((angle >= 0.0) & (angle <= np.pi / 2)))
    return np.cos(angle)


LAMBERT = Curve(np.cos, arccos_or_nan)
EXACT = Curve(np.cos, arccos_or_nan, lambda angle: -np.sin(angle))


@given(st.floats(0.05, 1.5), st.floats(1e-4, 0.1))
def test_sigma_agrees_with_the_closed_form(omega: float, sigma: float) -> None:
    given_angle = np.array([omega])
    expected = sigma / np.sin(omega)
    assert sigma_omega(given_angle, sigma, EXACT)[0] == pytest.approx(expected, rel=1e-12)
    assert sigma_omega(given_angle, sigma, LAMBERT)[0] == pytest.approx(expected, rel=1e-6)


def test_sigma_agrees_with_the_spread_of_many_noisy_returns() -> None:
    rng = np.random.default_rng(7)
    noisy = np.cos(np.deg2rad(40.0)) + rng.normal(0.0, 0.005, 20_000)
    spread = arccos_or_nan(noisy).std()
    predicted = sigma_omega(np.deg2rad(np.array([40.0])), 0.005, LAMBERT)[0]
    assert spread == pytest.approx(predicted, rel=0.03)


def test_the_curve_is_never_asked_outside_0_to_90_degrees() -> None:
    curve = Curve(undefined_outside, arccos_or_nan)
    sigma = sigma_omega(np.array([0.0, np.pi / 2, np.nan]), 0.01, curve)
    assert sigma[0] > np.pi
    assert sigma[1] == pytest.approx(0.01, rel=1e-3)
    assert np.isnan(sigma[2])


def test_a_level_curve_has_an_infinite_error() -> None:
    assert np.isinf(sigma_omega(np.array([0.0]), 0.01, EXACT)[0])


def test_doubts() -> None:
    angles = np.deg2rad(np.array([1.0, 40.0, 70.0]))
    intensity = np.append(np.cos(angles), [1.2, np.nan])
    result = invert_intensity(intensity, 0.02, EXACT)
    np.testing.assert_allclose(result.omega[:3], angles, rtol=1e-9)
    assert np.isnan(result.omega[3:]).all()
    expected = [Doubt.FLAT, Doubt.NONE, Doubt.BEYOND, Doubt.OUTSIDE, Doubt.OUTSIDE]
    assert result.doubt.tolist() == [int(doubt) for doubt in expected]


def test_limits_and_errors_per_point_are_followed() -> None:
    intensity = np.cos(np.deg2rad(np.array([30.0, 30.0, 50.0])))
    sigma = np.array([0.01, 0.4, np.nan])
    result = invert_intensity(
        intensity, sigma, EXACT, trusted_to=np.deg2rad(45.0), largest_sigma=np.deg2rad(10.0)
    )
    assert result.doubt.tolist() == [0, int(Doubt.FLAT), int(Doubt.FLAT | Doubt.BEYOND)]
