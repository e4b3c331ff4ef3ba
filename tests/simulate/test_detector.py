"""Detectors: closed forms, monotone, invertible, and as noisy as they say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from app.core.errors import WrongUse
from app.simulate.detector import (
    Digitiser,
    Ideal,
    Linear,
    Logarithmic,
    Salca,
    record,
    tabulate_strength,
)
from app.simulate.range_effect import Hancock, InverseSquare
from app.simulate.receiver import Receiver

WIDE = Digitiser(-1e6, 1e6, quantum=0.0)
EFFECT = Hancock((1.98, 1.50), (0.54, 0.18), (0.64, 0.84))
SQUARE = InverseSquare(3.56)
LINEAR = Linear((3e-4, 5e-4), (0.37, 0.1), WIDE, SQUARE)
LOGARITHMIC = Logarithmic((600.0, 1200.0), (1784.0, 2040.0), WIDE, SQUARE)
SALCA = Salca((35.19, 137.21), (342.45, 407.04), (7.33, 16.83), WIDE, EFFECT)
AMPLIFIERS = [LINEAR, LOGARITHMIC, SALCA]
QUIET = Receiver()


def random(seed=0):
    return np.random.default_rng(seed)


@pytest.mark.parametrize("detector", AMPLIFIERS)
@pytest.mark.parametrize("channel", [0, 1])
@given(first=st.floats(0.0, 3.0), second=st.floats(0.0, 3.0))
def test_responses_never_fall(detector, channel, first, second):
    low, high = detector.respond(np.array(sorted([first, second])), channel)
    assert low <= high


@pytest.mark.parametrize("detector", AMPLIFIERS)
@pytest.mark.parametrize("channel", [0, 1])
def test_responses_rise_and_have_the_slope_they_say(detector, channel):
    light = np.geomspace(1e-3, 3, 200)
    values = detector.respond(light, channel)
    assert (np.diff(values) > 0).all()
    step = 1e-6 * light
    rise = detector.respond(light + step, channel) - detector.respond(light - step, channel)
    np.testing.assert_allclose(detector.slope(light, channel), rise / (2 * step), rtol=1e-5)


def invert(detector, value, channel):
    """Effective reflectance of a DN, from the formulas of science.md 1.3 and 1.4."""
    if detector is LINEAR:
        return detector.a[channel] * value + detector.b[channel]
    if detector is LOGARITHMIC:
        return 10 ** ((value - detector.a1[channel]) / detector.a0[channel])
    m, c, k = detector.m[channel], detector.c[channel], detector.k[channel]
    return brentq(lambda rho: (m * rho + c) * (1 - np.exp(-k * rho)) - value, 0, 50, xtol=1e-14)


def fall(detector, distance, channel):
    """Range effect from its printed formula."""
    if detector is not SALCA:
        return (3.56 / distance) ** 2
    a, k2, k3 = EFFECT.a[channel], EFFECT.k2[channel], EFFECT.k3[channel]
    near, far = (r**-a * (1 - np.exp(-k2 * r)) ** k3 for r in (8.0, distance))
    return far / near


@pytest.mark.parametrize("detector", AMPLIFIERS)
@given(echo=st.tuples(st.floats(0.01, 1.0), st.floats(0.01, 1.0)), distance=st.floats(2.0, 40.0))
def test_a_quiet_record_read_backwards_gives_the_echo(detector, echo, distance):
    found = record(np.array([echo]), np.array([distance]), detector, QUIET, random())
    assert not found.saturated.any()
    np.testing.assert_array_equal(found.sigma, 0)
    for channel in (0, 1):
        light = invert(detector, found.values[0, channel], channel)
        back = light / fall(detector, distance, channel)
        assert back == pytest.approx(echo[channel], rel=1e-6)


@given(st.floats(0.0, 1.0), st.floats(0.1, 100.0))
def test_an_ideal_detector_reports_the_echo(echo, distance):
    found = record(np.array([[echo]]), np.array([distance]), Ideal(), QUIET, random())
    assert found.values == echo
    assert found.sigma == 0


NOISY = Digitiser(-1e6, 1e6, quantum=4.0, electronic_noise=3.0)


@pytest.mark.parametrize(
    "detector",
    [
        Ideal(),
        Linear((3e-4, 5e-4), (0.37, 0.1), NOISY, SQUARE),
        Logarithmic((600.0, 1200.0), (1784.0, 2040.0), NOISY, SQUARE),
        Salca((35.19, 137.21), (342.45, 407.04), (7.33, 16.83), NOISY, EFFECT),
    ],
)
@pytest.mark.parametrize("distance", [2.5, 9.0])
def test_values_scatter_as_their_sigma_says(detector, distance):
    count = 40_000
    echo = np.tile([0.4, 0.08], (count, 1))
    receiver = Receiver(intensity_noise=0.03)
    found = record(echo, np.full(count, distance), detector, receiver, random(3))
    np.testing.assert_allclose(found.values.std(axis=0), found.sigma[0], rtol=0.03)


@pytest.mark.parametrize("detector", [Ideal(), LINEAR, LOGARITHMIC, SALCA])
@pytest.mark.parametrize("distance", [2.5, 9.0])
def test_scatter_that_the_echo_has_already_enters_the_sigma_and_only_that(detector, distance):
    count, drawn = 40_000, random(8)
    scatter = np.array([0.012, 0.004])
    echo = np.array([0.4, 0.08]) + scatter * drawn.standard_normal((count, 2))
    receiver, away = Receiver(intensity_noise=0.02), np.full(count, distance)
    sigmas = np.tile(scatter, (count, 1))
    found = record(echo, away, detector, receiver, random(3), sigmas)
    np.testing.assert_allclose(found.values.std(axis=0), found.sigma.mean(axis=0), rtol=0.03)
    unaware = record(echo, away, detector, receiver, random(3))
    np.testing.assert_array_equal(found.values, unaware.values)
    assert (found.sigma > unaware.sigma).all()


@pytest.mark.parametrize("detector", AMPLIFIERS)
def test_tabulated_strength_is_that_of_the_range_effect(detector):
    table = tabulate_strength(detector, 2, 60.0)
    lattice = 0.002 * np.arange(table.shape[1])
    assert table.shape[0] == 2
    assert 60.0 <= lattice[-1] < 60.004
    assert np.isfinite(table).all()
    away = random(1).uniform(2.0 if detector is SALCA else 0.6, 60.0, 5000)
    for channel in (0, 1):
        found = np.interp(away, lattice, table[channel])
        expected = [fall(detector, distance, channel) for distance in away]
        np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize("detector", [Ideal(), Linear((3e-4, 5e-4), (0.37, 0.1), WIDE)])
def test_no_range_effect_is_an_empty_table(detector):
    assert tabulate_strength(detector, 2, 60.0).shape == (2, 0)


def test_both_ends_of_the_scale():
    detector = Logarithmic((600.0,), (1784.0,), Digitiser(0, 2047), SQUARE)
    echo = np.array([[1e-9], [0.0], [0.5], [0.9]])
    found = record(echo, np.array([3.56, 3.56, 3.56, 1.0]), detector, QUIET, random())
    np.testing.assert_array_equal(found.values[:, 0], [0, 0, 1603, 2047])
    np.testing.assert_array_equal(found.saturated[:, 0], [False, False, False, True])
    assert np.isfinite(found.sigma).all()


@given(st.floats(0.0, 1.0), st.sampled_from([0.25, 1.0, 8.0]))
def test_values_are_whole_quanta(echo, quantum):
    exact = Linear((3e-4,), (0.37,), WIDE)
    coarse = Linear((3e-4,), (0.37,), Digitiser(-1e4, 1e4, quantum))
    value = record(np.array([[echo]]), np.ones(1), coarse, QUIET, random()).values.item()
    assert value / quantum == round(value / quantum)
    assert abs(value - exact.respond(echo, 0)) <= quantum / 2 + 1e-9


def test_noise_never_makes_an_echo_negative():
    echo = np.full((20_000, 1), 0.5)
    found = record(echo, np.ones(20_000), Ideal(), Receiver(intensity_noise=0.9), random())
    assert found.values.min() == 0


def test_same_seed_same_record():
    echo, distance = np.full((50, 2), 0.4), np.full(50, 5.0)
    receiver = Receiver(intensity_noise=0.05)
    first, again, other = (
        record(echo, distance, SALCA, receiver, random(seed)).values for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).all()


def test_a_scene_with_other_channels_is_refused():
    with pytest.raises(WrongUse, match="2 channels, the scene 3"):
        record(np.ones((4, 3)), np.ones(4), LINEAR, QUIET, random())


def test_kinds():
    assert Ideal().kind == "reflectance"
    assert {detector.kind for detector in AMPLIFIERS} == {"DN"}


@pytest.mark.parametrize(
    "make",
    [
        lambda: Digitiser(10, 10),
        lambda: Digitiser(np.nan, 10),
        lambda: Digitiser(0, np.inf),
        lambda: Digitiser(0, 10, quantum=-1),
        lambda: Digitiser(0, 10, electronic_noise=np.nan),
        lambda: Linear((0.0,), (1.0,), WIDE),
        lambda: Linear((1.0,), (np.nan,), WIDE),
        lambda: Linear((), (), WIDE),
        lambda: Logarithmic((600.0,), (1.0, 2.0), WIDE),
        lambda: Logarithmic((-600.0,), (1.0,), WIDE),
        lambda: Salca((1.0,), (-1.0,), (1.0,), WIDE),
    ],
)
def test_impossible_detectors_are_refused(make):
    with pytest.raises(WrongUse):
        make()
