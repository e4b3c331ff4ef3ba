"""Noise from residuals, against the noise that was put in."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.radiometry.noise import estimate_noise, estimate_point_noise
from app.core.radiometry.profile import Noise
from app.core.radiometry.salca import SalcaResponse


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


@pytest.mark.parametrize("true", [Noise(2.0, 0.0, 0.03), Noise(1.0, 0.01), Noise(0.0, 0.005, 0.05)])
def test_noise_of_the_light_is_told_from_that_of_the_number(true: Noise) -> None:
    # SALCA: steep below the knee, shallow above, so that the three parts differ in shape.
    light, here = np.geomspace(0.005, 2.0, 60), np.ones(60)
    response = SalcaResponse(137.21, 407.04, 16.83)
    number, echo = response.respond(light, here), light * response.slope(light, here)
    scatter = true.sigma(number, echo)
    found = estimate_point_noise(scatter, number, echo)
    assert found.sigma(number, echo) == pytest.approx(scatter, rel=1e-3)
    drawn = scatter * (1.0 + np.random.default_rng(1).standard_normal(60) / np.sqrt(400))
    found = estimate_point_noise(drawn, number, echo)
    assert found.sigma(number, echo) == pytest.approx(scatter, rel=0.1)
