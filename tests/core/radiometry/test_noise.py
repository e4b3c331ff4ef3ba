"""Noise from residuals, against the noise that was put in."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.radiometry.noise import estimate_noise


@pytest.mark.parametrize(
    ("constant", "share"), [(1.0, 0.01), (0.2, 0.002), (5.0, 0.0), (0.0, 0.02)]
)
def test_noise_comes_back(constant: float, share: float) -> None:
    random = np.random.default_rng(4)
    fitted = np.geomspace(2.0, 700.0, 20_000)
    sigma = np.hypot(constant, share * fitted)
    found = estimate_noise(sigma * random.standard_normal(len(fitted)), fitted, 0)
    assert found.sigma(fitted) == pytest.approx(sigma, rel=0.05)


def test_a_fit_with_many_parameters_is_allowed_for() -> None:
    residual = np.tile([1.0, -1.0], 10)
    found = estimate_noise(residual, np.full(20, 50.0), 10)
    assert found.sigma(np.array(50.0)) == pytest.approx(np.sqrt(2.0), rel=1e-6)


def test_no_residuals_are_rounding_and_not_zero() -> None:
    found = estimate_noise(np.zeros(5), np.full(5, 100.0), 2)
    assert 0 < found.sigma(np.array(100.0)) < 1e-10
