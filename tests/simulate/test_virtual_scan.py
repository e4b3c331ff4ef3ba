"""A scan in one call: what its arguments change, and what "no noise" leaves."""

from dataclasses import replace

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.simulate.detector import Ideal, record
from app.simulate.instrument import get_instrument, list_instruments
from app.simulate.ranging import Pulsed
from app.simulate.virtual_scan import arrange, find_scene, set_noise, simulate


@pytest.mark.parametrize("name", [tool.name for tool in list_instruments()])
def test_no_noise_is_none_at_all(name):
    tool = set_noise(get_instrument(name), "none")
    receiver, detector, ranging = tool.receiver, tool.detector, tool.ranging
    assert receiver.range_noise == receiver.intensity_noise == receiver.dropout == 0
    if isinstance(ranging, Pulsed) and ranging.waveform is not None:
        assert ranging.waveform.noise == 0
    echo = np.full((200, len(tool.wavelengths_nm)), 0.37)
    found = record(echo, np.full(200, 5.0), detector, receiver, np.random.default_rng(1))
    np.testing.assert_array_equal(found.values, np.tile(found.values[0], (200, 1)))
    # What is left is rounding: no noise, but a σ.
    step = 0.0 if isinstance(detector, Ideal) else detector.scale.quantum
    np.testing.assert_allclose(found.sigma, step / np.sqrt(12))


def test_no_noise_changes_nothing_else():
    tool = get_instrument("salca")
    quiet = set_noise(tool, "none")
    scale = replace(quiet.detector.scale, electronic_noise=tool.detector.scale.electronic_noise)
    waveform = replace(quiet.ranging.waveform, noise=tool.ranging.waveform.noise)
    back = replace(
        quiet,
        receiver=tool.receiver,
        detector=replace(quiet.detector, scale=scale),
        ranging=replace(quiet.ranging, waveform=waveform),
    )
    assert back == tool


@pytest.mark.parametrize("noise", ["white", "filtered"])
def test_noise_by_name_changes_the_correlation_alone(noise):
    tool = get_instrument("ls880")
    found = set_noise(tool, noise)
    assert found == replace(tool, receiver=replace(tool.receiver, correlation=noise))


@pytest.mark.parametrize("step", [0, -1.0])
def test_a_step_of_nothing_is_refused_not_replaced(step):
    with pytest.raises(WrongUse, match="step"):
        simulate("leaf", step_deg=step)


def test_the_step_is_that_asked_for_then_the_scenes_then_the_instruments():
    tool, scene = get_instrument("two_colour"), find_scene("leaf")
    assert arrange(scene, tool, 0.5).grid.step == pytest.approx(np.deg2rad(0.5))
    own = tool.step_deg if scene.step_deg is None else scene.step_deg
    assert arrange(scene, tool).grid.step == pytest.approx(np.deg2rad(own))
