"""Digitised returns against closed forms and against plain pulsed ranging."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.simulate.ranging import Pulsed, pulsed_ranges
from app.simulate.waveform import Waveform, find_returns, sample_waveform

FINE = Waveform(step=0.01, samples=2048)


def test_a_pulse_has_its_height_and_its_width():
    ranges, values = sample_waveform([5.0], [0.7], 0.2, FINE)
    assert values.max() == pytest.approx(0.7, rel=1e-3)
    half = ranges[values >= 0.35]
    assert half[-1] - half[0] == pytest.approx(0.2, abs=0.011)


def test_echoes_add_up():
    _, both = sample_waveform([5.0, 5.1], [0.7, 0.2], 0.2, FINE)
    ranges, first = sample_waveform([5.0], [0.7], 0.2, FINE)
    second = 0.2 * 2 ** (-(((ranges - 5.1) / 0.1) ** 2))
    np.testing.assert_allclose(both, first + second, atol=1e-12)


@given(st.floats(0.5, 50.0), st.floats(0.05, 1.0))
def test_one_surface_gives_its_range_and_energy(distance, energy):
    record = sample_waveform([distance], [energy], 0.2, FINE)
    ranges, energies = find_returns(*record, 0.2, 0.0, FINE)
    assert ranges == pytest.approx([distance], abs=1e-6)
    assert energies == pytest.approx([energy], rel=1e-6)


@given(st.floats(2.0, 10.0), st.floats(0.8, 5.0), st.floats(0.2, 0.8))
def test_surfaces_far_apart_give_what_plain_ranging_gives(front, gap, share):
    distances, energies = [front, front + gap], [share, 1 - share]
    plain = pulsed_ranges(distances, energies, Pulsed(0.2, 0.3, "all"))
    digital = pulsed_ranges(distances, energies, Pulsed(0.2, 0.3, "all", waveform=FINE))
    # 5 % of the highest peak are up to a fifth of the lower one, which then lacks its feet.
    np.testing.assert_allclose(np.array(digital)[:, 0], np.array(plain)[:, 0], atol=0.006)
    np.testing.assert_allclose(np.array(digital)[:, 1], np.array(plain)[:, 1], rtol=0.09)


def test_surfaces_within_a_pulse_blend_at_their_mean():
    (found,) = pulsed_ranges(
        [4.0, 4.1], [0.5, 0.5], Pulsed(0.2, 0.3, "all", least=0.0, waveform=FINE)
    )
    assert found == pytest.approx((4.05, 1.0), abs=1e-6)


def test_what_lies_behind_the_record_is_lost():
    short = Waveform(step=0.15, samples=16)
    pulsed = Pulsed(0.15, 0.15, "all", waveform=short)
    assert len(pulsed_ranges([3.0, 5.5], [0.5, 0.5], pulsed)) == 1
    assert len(pulsed_ranges([3.0, 4.5], [0.5, 0.5], pulsed)) == 2


def test_noise_spreads_the_range_as_the_centroid_predicts():
    waveform = Waveform(step=0.05, samples=64, noise=0.01)
    pulsed = Pulsed(0.2, 0.2, "strongest", least=0.35, waveform=waveform)
    random = np.random.default_rng(7)
    found = np.array(
        [pulsed_ranges([5.0], [0.8], pulsed, random.standard_normal(64))[0][0] for _ in range(3000)]
    )
    # Centroid Σ r v / Σ v of what rises over the gate: σ = noise · √Σ (r − d)² / Σ v.
    ranges, values = sample_waveform([5.0], [0.8], 0.2, waveform)
    run = values > 0.35 * values.max()
    over = values[run] - 0.35 * values.max()
    predicted = 0.01 * np.sqrt(((ranges[run] - 5) ** 2).sum()) / over.sum()
    assert found.std() == pytest.approx(predicted, rel=0.06)
    assert found.mean() == pytest.approx(5.0, abs=1e-3)


def test_noise_alone_hardly_ever_gives_a_return():
    waveform = Waveform(step=0.15, samples=128, noise=0.01)
    pulsed = Pulsed(0.15, 0.15, "all", least=0.0, waveform=waveform)
    random = np.random.default_rng(3)
    counts = [
        len(pulsed_ranges([5.0], [0.5], pulsed, random.standard_normal(128))) for _ in range(500)
    ]
    assert min(counts) == 1
    assert np.mean(counts) < 1.02


@pytest.mark.parametrize(
    "faults", [{"step": 0.0}, {"samples": 7}, {"samples": 4097}, {"noise": -1.0}]
)
def test_impossible_records_are_refused(faults):
    with pytest.raises(WrongUse, match="waveform"):
        Waveform(**faults)
