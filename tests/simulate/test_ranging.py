"""Phase-shift and pulsed ranging against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.simulate.ranging import PhaseShift, Pulsed, count_octaves, phase_range, pulsed_ranges


@given(st.floats(0.1, 38.0))
def test_one_surface_gives_its_own_range(distance):
    assert phase_range([distance], [0.3]) == pytest.approx(distance, abs=1e-9)


@given(st.floats(1.0, 10.0), st.floats(0.0, 0.25), st.floats(0.05, 0.95))
def test_two_close_surfaces_give_the_phase_of_their_sum(front, gap, share):
    # Seen from the first surface: tan φ = E2 sin β / (E1 + E2 cos β), β = 4π gap / 1.2 m.
    beta = 4 * np.pi * gap / 1.2
    phase = np.arctan2((1 - share) * np.sin(beta), share + (1 - share) * np.cos(beta))
    expected = front + phase * 1.2 / (4 * np.pi)
    found = phase_range([front, front + gap], [share, 1 - share])
    assert found == pytest.approx(expected, abs=1e-9)
    assert front - 1e-9 <= found <= front + gap + 1e-9


def test_distant_surfaces_differ_from_the_fine_phase_by_whole_cycles():
    front, back = 2.7, 5.63
    weights = np.array([0.6, 0.4])
    total = (weights * np.exp(4j * np.pi * np.array([front, back]) / 1.2)).sum()
    fine = np.angle(total) * 1.2 / (4 * np.pi)
    cycles = (phase_range([front, back], weights) - fine) / 0.6
    assert cycles == pytest.approx(round(cycles), abs=1e-9)
    assert min(abs(phase_range([front, back], weights) - d) for d in (front, back)) > 0.006


def test_octaves_of_the_modulation():
    np.testing.assert_array_equal(count_octaves((76.8, 9.6, 1.2)), [0, 3, 3])
    with pytest.raises(WrongUse, match="coarse to fine"):
        count_octaves((76.8, 10.0))
    with pytest.raises(WrongUse, match="coarse to fine"):
        count_octaves((1.2, 9.6))


@given(st.floats(0.0, 500.0), st.sampled_from([(76.8, 9.6, 1.2), (153.6, 9.6, 1.2), (20.0,)]))
def test_ranges_fold_at_half_of_the_coarsest_wavelength(distance, wavelengths):
    limit = PhaseShift(wavelengths).unambiguous
    found = phase_range([distance], [1.0], wavelengths)
    assert 0 <= found < limit
    away = abs(found - distance % limit)
    assert min(away, limit - away) < 1e-9


@given(
    st.lists(st.tuples(st.floats(0.5, 30.0), st.floats(0.01, 1.0)), min_size=1, max_size=8),
    st.integers(-20, 20),
)
def test_the_phase_does_not_depend_on_the_brightness_of_all(echoes, power):
    distances, energies = np.array(echoes).T
    # A power of two scales without rounding, so that even echoes that cancel stay as they are.
    assert phase_range(distances, energies * 2.0**power) == phase_range(distances, energies)


@pytest.mark.parametrize("wavelengths", [(), (0.0,), (-1.2,), (76.8, np.nan), (np.inf,)])
def test_impossible_modulations_are_refused(wavelengths):
    with pytest.raises(WrongUse, match="modulation wavelength"):
        PhaseShift(wavelengths)


TWO = Pulsed(pulse=0.15, blend=0.25, pick="all")


@given(st.floats(1.0, 20.0), st.floats(0.0, 0.249), st.floats(0.05, 0.95))
def test_surfaces_nearer_than_the_blend_give_one_mean(front, gap, share):
    (found,) = pulsed_ranges([front + gap, front], [1 - share, share], TWO)
    assert found == pytest.approx((front + (1 - share) * gap, 1.0), abs=1e-9)


@given(st.floats(1.0, 20.0), st.floats(0.2501, 9.0), st.floats(0.06, 0.94))
def test_surfaces_beyond_the_blend_stay_apart(front, gap, share):
    near, far = pulsed_ranges([front + gap, front], [1 - share, share], TWO)
    assert near == pytest.approx((front, share))
    assert far == pytest.approx((front + gap, 1 - share))


def test_a_slope_of_many_echoes_is_one_return():
    distances = 3 + 0.2 * np.arange(10)
    assert pulsed_ranges(distances, np.ones(10), TWO) == [pytest.approx((3.9, 10.0))]


def test_what_is_picked():
    distances, energies = [2.0, 3.0, 4.0, 5.0], [0.2, 0.5, 0.03, 0.27]
    picked = {
        pick: [r for r, _ in pulsed_ranges(distances, energies, Pulsed(0.15, 0.25, pick))]
        for pick in ("first", "strongest", "last", "all")
    }
    assert picked == {"first": [2], "strongest": [3], "last": [5], "all": [2, 3, 5]}
    two = Pulsed(0.15, 0.25, "all", least=0.0, most=2)
    assert pulsed_ranges(distances, energies, two) == [(3, 0.5), (5, 0.27)]


def test_a_first_return_that_is_too_weak_is_not_noticed():
    weak = Pulsed(0.15, 0.25, "first", least=0.05)
    assert pulsed_ranges([2.0, 3.0], [0.049, 0.951], weak) == [(3.0, 0.951)]
    assert pulsed_ranges([2.0, 3.0], [0.051, 0.949], weak) == [(2.0, 0.051)]


def test_nothing_comes_back_from_nothing():
    assert pulsed_ranges([], [], TWO) == []
    assert pulsed_ranges([2.0], [0.0], TWO) == []


@given(
    st.lists(st.tuples(st.floats(0.5, 30.0), st.floats(0.0, 1.0)), min_size=1, max_size=12),
    st.randoms(use_true_random=False),
)
def test_pulsed_ranges_keep_energy_and_ignore_order(echoes, shuffler):
    distances, energies = np.array(echoes).T
    everything = Pulsed(0.15, 0.25, "all", least=0.0, most=15)
    returns = np.array(pulsed_ranges(distances, energies, everything)).reshape(-1, 2)
    assert returns[:, 1].sum() == pytest.approx(energies.sum())
    assert (returns[:, 0] @ returns[:, 1]) == pytest.approx(distances @ energies)
    order = list(range(len(echoes)))
    shuffler.shuffle(order)
    again = pulsed_ranges(distances[order], energies[order], everything)
    np.testing.assert_allclose(np.array(again).reshape(-1, 2), returns)


@pytest.mark.parametrize(
    "faults",
    [
        {"pulse": 0.0},
        {"pulse": np.nan},
        {"blend": -0.1},
        {"pick": "best"},
        {"least": 1.0},
        {"least": -0.1},
        {"most": 0},
    ],
)
def test_impossible_pulses_are_refused(faults):
    with pytest.raises(WrongUse, match="cannot"):
        Pulsed(**({"pulse": 0.15, "blend": 0.25} | faults))
