"""The wrinkle index: what raises it, and what does not."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.wrinkling.index import find_index

U, V = (side.ravel() for side in np.meshgrid(np.linspace(0, 0.07, 70), np.linspace(0, 0.045, 45)))
FLAT = np.stack([U, V], axis=1)
FOOTPRINT = 0.0041


def index(omega, noise=0.0, seed=1):
    """The index of angles with noise of a known size."""
    random = np.random.default_rng(seed)
    noisy = omega + noise * random.standard_normal(len(omega))
    return find_index(noisy, np.full(len(omega), noise), FLAT, FOOTPRINT)


def waves(amplitude_deg, mean_deg=40.0, length=0.013):
    return np.deg2rad(mean_deg + amplitude_deg * np.sin(2 * np.pi * U / length))


@pytest.mark.parametrize("amplitude", [3.0, 8.0])
def test_waves_give_about_their_amplitude(amplitude):
    found = index(waves(amplitude))
    assert np.rad2deg(found.value) == pytest.approx(amplitude, rel=0.2)
    assert found.low <= found.value <= found.high
    assert found.degree == 3


def test_noise_does_not_raise_it():
    quiet, noisy = index(waves(5.0)), index(waves(5.0), np.deg2rad(2.0))
    assert noisy.value == pytest.approx(quiet.value, rel=0.15)
    assert np.rad2deg(index(np.full(len(U), 0.7), np.deg2rad(2.0)).value) < 0.6


@pytest.mark.parametrize("mean", [0.1, 0.6, 0.9])
def test_a_bend_does_not_raise_it(mean):
    # A cylinder of 15 per metre: the normal turns by 0.5 from border to border, along any side.
    bend = np.arccos(np.cos(mean + 15.0 * (U - U.mean()) * 0.5) * np.cos(3.0 * (V - V.mean())))
    assert np.rad2deg(index(bend).value) < 0.4
    assert np.rad2deg(index(bend, np.deg2rad(1.0)).value) < 0.6


def test_a_few_outliers_do_not_raise_it():
    omega = np.full(len(U), 0.7)
    omega[::15] = 1.2
    assert np.rad2deg(index(omega, np.deg2rad(1.0)).value) < 0.6


def test_the_interval_covers_the_index_of_many_points():
    truth = np.rad2deg(index(waves(6.0)).value)
    found = [index(waves(6.0), np.deg2rad(1.0), seed) for seed in range(20)]
    held = [np.rad2deg(i.low) - 0.2 <= truth <= np.rad2deg(i.high) + 0.2 for i in found]
    assert np.mean(held) >= 0.9


def test_refusals():
    with pytest.raises(BadInput, match="30 points"):
        find_index(np.full(29, 0.7), np.zeros(29), FLAT[:29], FOOTPRINT)
    with pytest.raises(BadInput, match="footprints"):
        find_index(np.full(100, 0.7), np.zeros(100), np.zeros((100, 2)), FOOTPRINT)
    with pytest.raises(BadInput, match="size"):
        find_index(np.full(100, 0.7), np.zeros(100), FLAT[:100], 0.0)
