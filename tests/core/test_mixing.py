"""Ranges of beams on two surfaces against the simulator's own plain formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.core.mixing import PhaseMixing, PulseMixing, covered_share, mixed_range
from app.simulate.beam import Bundle
from app.simulate.ranging import Pulsed, phase_range, pulsed_ranges

WAVELENGTHS = (76.8, 9.6, 1.2)


@given(st.floats(0.01, 3.0), st.floats(0.01, 100.0))
def test_phases_mix_as_in_the_simulator(gap: float, ratio: float) -> None:
    start = 20.0
    told = phase_range(np.array([start, start + gap]), np.array([1.0, ratio]), WAVELENGTHS) - start
    found = float(mixed_range(ratio, gap, PhaseMixing(WAVELENGTHS)))
    # Where two cycles fit equally well either may be taken.
    assert abs(found - told) < 1e-9 or abs(abs(found - told) / 0.6 % 1.0) < 1e-6


@given(st.floats(0.01, 1.0), st.floats(0.001, 1000.0))
def test_pulses_mix_as_in_the_simulator(gap: float, ratio: float) -> None:
    pulsed = Pulsed(0.15, 0.25, "first", 0.05)
    ((told, _), *_) = pulsed_ranges(np.array([5.0, 5.0 + gap]), np.array([1.0, ratio]), pulsed)
    found = float(mixed_range(ratio, gap, PulseMixing(0.25, 0.05)))
    assert found == pytest.approx(told - 5.0, abs=1e-9)


@pytest.mark.parametrize("mixing", [PhaseMixing(WAVELENGTHS), PulseMixing(0.25, 0.05)])
def test_whole_hits_are_on_their_surface(mixing: PhaseMixing | PulseMixing) -> None:
    found = mixed_range(np.array([0.0, 1e12, np.inf]), 0.2, mixing)
    assert found == pytest.approx([0.0, 0.2, 0.2], abs=1e-9)


def test_the_share_is_that_of_the_simulators_subrays() -> None:
    x, _, share = Bundle(rays=20_000).subrays().T
    for inside in (-0.9, -0.5, 0.0, 0.2, 0.8):
        assert covered_share(inside) == pytest.approx(share[x <= inside].sum(), abs=2e-3)
    assert covered_share([-3.0, -1.0, 0.0, 1.0, 7.0]) == pytest.approx([0, 0, 0.5, 1, 1], abs=1e-9)


def test_bad_rangings_are_refused() -> None:
    with pytest.raises(WrongUse, match="modulation wavelengths"):
        PhaseMixing(())
    with pytest.raises(WrongUse, match="modulation wavelengths"):
        PhaseMixing((float("nan"),))
    for blend, least in ((0.0, 0.0), (0.1, 1.0), (float("inf"), 0.0)):
        with pytest.raises(WrongUse, match="pulse longer than 0"):
            PulseMixing(blend, least)
