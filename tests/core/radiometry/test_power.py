"""Laser power of a new scan from panels in it."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.radiometry import chain as chains
from app.core.radiometry.drift import Power
from app.core.radiometry.log_response import LogResponse
from app.core.radiometry.power import measure_power
from app.core.radiometry.profile import ChannelCalibration, Noise
from app.core.radiometry.range_effect import AnalyticRange
from app.core.radiometry.salca import SalcaResponse

RHO, AWAY = np.array([0.05, 0.1, 0.2, 0.4, 0.65, 0.9]), np.full(6, 8.0)
SALCA = ChannelCalibration(
    "s",
    (Power(1.0), AnalyticRange(1.5, 0.18, 0.84), SalcaResponse(137.21, 407.04, 16.83)),
    1545.0,
    saturated=460.0,
    noise=Noise(1.0, 0.01),
)
LOG = ChannelCalibration("l", (Power(1.0), LogResponse(600.0, 1784.0)), 785.0, noise=Noise(3.0))


@pytest.mark.parametrize("calibration", [SALCA, LOG])
def test_the_power_comes_back_without_noise(calibration: ChannelCalibration) -> None:
    dn = chains.respond(calibration.steps, 0.73 * RHO, AWAY)
    power, sigma, _ = measure_power(calibration, dn, AWAY, RHO)
    assert power == pytest.approx(0.73, rel=1e-9)
    assert 0 < sigma < 0.02


@pytest.mark.parametrize("calibration", [SALCA, LOG])
def test_its_sigma_is_that_of_many_draws(calibration: ChannelCalibration) -> None:
    random = np.random.default_rng(2)
    dn = chains.respond(calibration.steps, 0.8 * RHO, AWAY)
    assert calibration.noise is not None
    noise = calibration.noise.sigma(dn)
    draws = [dn + noise * random.standard_normal(6) for _ in range(1500)]
    found = np.array([measure_power(calibration, draw, AWAY, RHO)[:2] for draw in draws])
    assert found[:, 0].mean() == pytest.approx(0.8, rel=0.003)
    assert found[:, 0].std() == pytest.approx(found[:, 1].mean(), rel=0.1)


@pytest.mark.parametrize("calibration", [SALCA, LOG])
def test_its_pull_is_what_other_parameters_do_to_it(calibration: ChannelCalibration) -> None:
    dn = chains.respond(calibration.steps, 0.8 * RHO, AWAY)
    values = chains.values(calibration.steps)
    pull = measure_power(calibration, dn, AWAY, RHO).pull
    for k in range(1, len(values)):  # the first is the power itself
        step = 1e-6 * abs(values[k])
        ends = []
        for sign in (-1, 1):
            moved = values + sign * step * (np.arange(len(values)) == k)
            steps = chains.with_values(calibration.steps, moved)
            other = msgspec.structs.replace(calibration, steps=steps)
            ends.append(measure_power(other, dn, AWAY, RHO).power)
        assert (ends[1] - ends[0]) / (2 * step) == pytest.approx(pull[k], rel=1e-3)


def test_panels_of_unsure_reflectance_make_it_unsure() -> None:
    dn = chains.respond(LOG.steps, RHO, AWAY)
    sure = measure_power(LOG, dn, AWAY, RHO)[1]
    unsure = measure_power(LOG, dn, AWAY, RHO, 0.05 * RHO)[1]
    assert unsure**2 == pytest.approx(sure**2 + 0.05**2 / 6, rel=1e-6)


def test_no_usable_panel_is_told() -> None:
    with pytest.raises(BadInput, match="No panel of this scan"):
        measure_power(SALCA, np.full(6, 470.0), AWAY, RHO)
