"""σ of reflectance against Monte Carlo: parameters, power, numbers and ranges drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.radiometry import chain as chains
from app.core.radiometry.budget import PARTS, error_budget, mean_budget
from app.core.radiometry.drift import Power
from app.core.radiometry.linear_response import LinearResponse
from app.core.radiometry.log_response import Decibel, LogResponse
from app.core.radiometry.profile import ChannelCalibration, Noise
from app.core.radiometry.range_curve import PolynomialCurve
from app.core.radiometry.range_effect import AnalyticRange, InverseSquare
from app.core.radiometry.salca import SalcaResponse

DRAWS = 40_000
POWER, POWER_SIGMA = 0.8, 0.008
CHAINS = {
    "SALCA": (AnalyticRange(1.5, 0.18, 0.84), Power(), SalcaResponse(137.21, 407.04, 16.83)),
    "log": (
        Power(),
        LogResponse(600.0, 1784.0),
        PolynomialCurve("additive", (2.0, 8.0, 60.0), (120.0, 0.0, -500.0), 8.0, order=2),
    ),
    "linear": (InverseSquare(8.0), Power(), LinearResponse(3e-4, 0.05)),
}


def calibrate(name: str, size: float = 0.004) -> ChannelCalibration:
    """A calibration with correlated errors of all parameters but the power."""
    steps = CHAINS[name]
    values, names = chains.values(steps), chains.names(steps)
    random = np.random.default_rng(3)
    spread = random.standard_normal((len(values), len(values))) * size * np.abs(values)[:, None]
    spread[[n == "value" for n in names]] = 0.0
    fit = spread @ spread.T / len(values)
    panel = np.outer(spread[:, 0], spread[:, 0])
    return ChannelCalibration(
        "test",
        steps,
        noise=Noise(1.0, 0.004),
        range_sigma=0.01,
        fit_covariance=tuple(map(tuple, fit)),
        panel_covariance=tuple(map(tuple, panel)),
    )


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize(("rho", "distance"), [(0.08, 5.0), (0.4, 12.0), (0.85, 20.0)])
def test_predicted_sigma_is_that_of_many_draws(name: str, rho: float, distance: float) -> None:
    calibration = calibrate(name)
    random = np.random.default_rng(11)
    true = chains.with_power(calibration.steps, POWER)
    number = chains.respond(true, np.array([rho]), np.array([distance]))[0]
    covariance = calibration.covariance("fit") + calibration.covariance("panel")
    drawn = random.multivariate_normal(chains.values(true), covariance, DRAWS, method="eigh")
    numbers = number + calibration.noise.sigma(np.array(number)) * random.standard_normal(DRAWS)
    ranges = distance + calibration.range_sigma * random.standard_normal(DRAWS)
    powers = POWER + POWER_SIGMA * random.standard_normal(DRAWS)
    found = np.array(
        [
            chains.invert(chains.with_power(chains.with_values(true, v), p), n[None], d[None])[0]
            for v, p, n, d in zip(drawn[:4000], powers, numbers, ranges, strict=False)
        ]
    )
    budget = error_budget(
        calibration, np.array([rho]), np.array([number]), np.array([distance]), POWER, POWER_SIGMA
    )
    assert budget.sigma[0] == pytest.approx(np.std(found), rel=0.06)
    assert np.mean(found) == pytest.approx(rho, abs=0.2 * np.std(found))


@pytest.mark.parametrize("name", CHAINS)
def test_parts_add_up_in_squares_and_each_follows_its_cause(name: str) -> None:
    calibration = calibrate(name)
    rho, distance = np.array([0.2, 0.6]), np.array([6.0, 15.0])
    number = chains.respond(chains.with_power(calibration.steps, POWER), rho, distance)
    budget = error_budget(calibration, rho, number, distance, POWER, POWER_SIGMA)
    assert set(budget._fields) == set(PARTS)
    np.testing.assert_allclose(budget.sigma**2, sum(part**2 for part in budget))
    np.testing.assert_allclose(budget.power, rho * POWER_SIGMA / POWER)
    none = error_budget(calibration, rho, number, distance, POWER)
    assert (none.power == 0.0).all()
    np.testing.assert_array_equal(none.fit, budget.fit)


def test_noise_of_a_mean_falls_and_shared_errors_do_not() -> None:
    calibration, n = calibrate("SALCA"), 400
    rho, distance = np.full(n, 0.3), np.full(n, 10.0)
    number = chains.respond(calibration.steps, rho, distance)
    one = error_budget(calibration, rho, number, distance, 1.0, 0.01)
    mean = mean_budget(calibration, rho, number, distance, 1.0, 0.01)
    for part, share in zip(PARTS, (20.0, 1.0, 1.0, 1.0, 20.0), strict=True):
        assert getattr(mean, part)[0] == pytest.approx(getattr(one, part)[0] / share, rel=1e-9)


def test_points_without_reflectance_have_no_sigma_and_stay_out_of_a_mean() -> None:
    calibration = calibrate("linear")
    rho, distance = np.array([0.3, np.nan]), np.array([5.0, 5.0])
    number = np.array([chains.respond(calibration.steps, rho[:1], distance[:1])[0], 7.0])
    budget = error_budget(calibration, rho, number, distance)
    assert np.isfinite(budget.sigma[0])
    assert np.isnan(budget.sigma[1])
    mean = mean_budget(calibration, rho, number, distance)
    assert mean.sigma[0] == pytest.approx(budget.sigma[0])
    assert np.isnan(mean_budget(calibration, rho[1:], number[1:], distance[1:]).sigma).all()


def test_what_nobody_published_makes_sigma_unknown() -> None:
    steps = CHAINS["linear"]
    rho, at = np.array([0.3]), np.array([5.0])
    number = chains.respond(steps, rho, at)
    silent = ChannelCalibration("test", steps, noise=Noise(1.0))
    budget = error_budget(silent, rho, number, at)
    assert np.isfinite(budget.noise).all()
    assert np.isnan(budget.fit).all()
    assert np.isnan(budget.sigma).all()
    noisy = ChannelCalibration("dB", (Decibel(),), noise=Noise(0.1))
    sure = error_budget(noisy, rho, np.array([-5.2]), at)
    assert sure.sigma[0] == pytest.approx(0.3 * 0.1 * np.log(10) / 10)


def test_no_point_has_no_budget() -> None:
    none = np.empty(0)
    assert error_budget(calibrate("log"), none, none, none).sigma.shape == (0,)
