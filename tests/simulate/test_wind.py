"""Wind: leaves move, neighbours not in step."""

import numpy as np
import pytest

from app.simulate.scenes import MATT
from app.simulate.surfaces import Leaf, Scene, Stem
from app.simulate.wind import Wind, apply_wind

LEAVES = tuple(Leaf((3, 0.01 * k, 0), (0, 0, -1), (-1, 0, 0), 0.05, 0.03, MATT) for k in range(500))
SCENE = Scene("still", LEAVES, (Stem((3, 0, 0), (3, 0, 1), 0.01, MATT),))


def test_leaves_sway_by_the_amplitude_in_the_direction_of_the_wind():
    windy = apply_wind(SCENE, Wind(amplitude=0.01, columns=80, azimuth_deg=30), random(1))
    sway = np.array([leaf.sway for leaf in windy.leaves])
    assert np.median(np.linalg.norm(sway, axis=1)) == pytest.approx(0.01, rel=0.08)
    azimuth = np.rad2deg(np.arctan2(sway[:, 1], sway[:, 0]))
    assert azimuth.mean() == pytest.approx(30, abs=2)
    rate = np.array([leaf.sway_rate for leaf in windy.leaves])
    assert np.median(2 * np.pi / rate) == pytest.approx(80, rel=0.05)
    assert windy.stems == SCENE.stems


def test_neighbours_are_not_in_step():
    phase = np.array([leaf.sway_phase for leaf in apply_wind(SCENE, Wind(), random(1)).leaves])
    assert abs(np.exp(1j * (phase[1:] - phase[:-1])).mean()) < 0.15
    assert abs(np.exp(1j * phase).mean()) < 0.15


def test_no_wind_changes_nothing_and_the_seed_decides():
    assert apply_wind(SCENE, Wind(amplitude=0.0), random(1)) == SCENE
    assert apply_wind(SCENE, Wind(), random(1)) == apply_wind(SCENE, Wind(), random(1))
    assert apply_wind(SCENE, Wind(), random(1)) != apply_wind(SCENE, Wind(), random(2))


def random(seed):
    return np.random.default_rng(seed)
