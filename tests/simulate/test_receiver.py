"""Range noise, its correlation, and what a receiver notices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.simulate.receiver import Receiver, choose_returns, draw_noise, range_sigma

LS880 = Receiver(range_noise=0.0026)


def test_range_noise_of_the_ls880():
    found = range_sigma(np.array([0.9, 0.1]), np.full(2, 10.0), LS880)
    np.testing.assert_allclose(found, [0.0026, 0.0052], rtol=1e-12)


@given(st.floats(0.02, 1.0), st.floats(0.5, 70.0))
def test_range_noise_follows_the_received_power_where_its_range_is_stated(echo, distance):
    """0.9 · (reference / d)² comes back from white; so little does from grey at the reference."""
    stated = Receiver(range_noise=0.0026, range_noise_power=0.3, threshold=0.0, reference=10.0)
    away, at_reference = np.array([distance]), np.array([10.0])
    found = range_sigma(np.array([echo]), away, stated)
    power = np.array([echo * (10.0 / distance) ** 2])
    assert found == pytest.approx(range_sigma(power, at_reference, stated), rel=1e-9)
    plain = Receiver(range_noise=0.0026, range_noise_power=0.3, threshold=0.0)
    assert range_sigma(np.array([echo]), at_reference, stated) == pytest.approx(
        range_sigma(np.array([echo]), away, plain)
    )


def test_range_noise_is_finite_at_the_scanner():
    near = range_sigma(np.array([0.5]), np.zeros(1), Receiver(range_noise=0.001, reference=10.0))
    np.testing.assert_array_equal(near, 0)


@given(st.floats(0.0, 1.2), st.floats(0.0, 1.2))
def test_weaker_echoes_are_never_more_certain(first, second):
    weak, strong = sorted([first, second])
    near, far = range_sigma(np.array([weak, strong]), np.full(2, 5.0), LS880)
    assert near >= far > 0


def test_range_noise_is_as_predicted():
    random = np.random.default_rng(1)
    for echo in (0.9, 0.3, 0.05):
        sigma = range_sigma(np.full(20000, echo), np.full(20000, 5.0), LS880)
        noise = sigma * draw_noise((1, 20000), np.arange(20000), "white", random)
        assert noise.std() == pytest.approx(sigma[0], rel=0.03)


def correlate(field, down, across):
    rows, columns = field.shape
    left = field[: rows - down, : columns - across]
    return np.corrcoef(left.ravel(), field[down:, across:].ravel())[0, 1]


def test_filtered_noise_has_unit_variance_and_the_correlation_of_a_mean_of_nine():
    shape = (400, 500)
    noise = draw_noise(shape, np.arange(200_000), "filtered", np.random.default_rng(2))
    field = noise.reshape(shape)
    assert field.std() == pytest.approx(1.0, abs=0.01)
    edge = np.concatenate([field[0], field[-1], field[:, 0], field[:, -1]])
    assert edge.std() == pytest.approx(1.0, abs=0.08)
    expected = {
        (0, 1): 2 / 3,
        (0, 2): 1 / 3,
        (0, 3): 0,
        (1, 0): 2 / 3,
        (1, 1): 4 / 9,
        (2, 2): 1 / 9,
    }
    for (down, across), value in expected.items():
        assert correlate(field, down, across) == pytest.approx(value, abs=0.02)


def test_white_noise_is_white():
    noise = draw_noise((300, 300), np.arange(90_000), "white", np.random.default_rng(2))
    assert noise.std() == pytest.approx(1.0, abs=0.01)
    assert correlate(noise.reshape(300, 300), 0, 1) == pytest.approx(0.0, abs=0.015)


@given(st.sets(st.integers(0, 11), min_size=1))
def test_filtered_noise_of_a_cell_does_not_depend_on_the_returns(cells):
    some = np.array(sorted(cells))
    whole = draw_noise((3, 4), np.arange(12), "filtered", np.random.default_rng(5))
    part = draw_noise((3, 4), some, "filtered", np.random.default_rng(5))
    np.testing.assert_array_equal(part, whole[some])


@pytest.mark.parametrize("correlation", ["white", "filtered"])
def test_same_seed_same_noise(correlation):
    cells = np.array([0, 3, 3, 8])
    first, again, other = (
        draw_noise((3, 3), cells, correlation, np.random.default_rng(seed)) for seed in (4, 4, 5)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).all()


def test_returns_are_kept_by_threshold_and_range():
    receiver = Receiver(threshold=0.1, nearest=1.0, farthest=10.0)
    distance = np.array([0.99, 1.0, 5.0, 5.0, 10.0, 10.1])
    echo = np.array([0.5, 0.5, 0.09, 0.1, 0.5, 0.5])
    kept = choose_returns(distance, echo, receiver, np.random.default_rng(0))
    np.testing.assert_array_equal(kept, [False, True, False, True, True, False])


def test_dropouts_lose_their_share():
    receiver = Receiver(dropout=0.2)
    distance, echo = np.full(50_000, 3.0), np.full(50_000, 0.5)
    kept = choose_returns(distance, echo, receiver, np.random.default_rng(0))
    assert kept.mean() == pytest.approx(0.8, abs=0.006)
    again = choose_returns(distance, echo, receiver, np.random.default_rng(0))
    np.testing.assert_array_equal(kept, again)


@pytest.mark.parametrize(
    "faults",
    [
        {"range_noise": -0.001},
        {"range_noise": np.nan},
        {"range_noise_power": -1.0},
        {"intensity_noise": 1.5},
        {"threshold": -0.1},
        {"correlation": "pink"},
        {"dropout": 1.0},
        {"nearest": -1.0},
        {"nearest": 5.0, "farthest": 4.0},
        {"farthest": np.nan},
        {"reference": 0.0},
        {"reference": np.nan},
    ],
)
def test_impossible_receivers_are_refused(faults):
    with pytest.raises(WrongUse, match="cannot"):
        Receiver(**faults)
