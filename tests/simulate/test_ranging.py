"""Phase-shift ranging against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.simulate.ranging import count_octaves, phase_range


@settings(deadline=None)  # the first call compiles
@given(st.floats(0.1, 38.0))
def test_one_surface_gives_its_own_range(distance):
    assert phase_range([distance], [0.3]) == pytest.approx(distance, abs=1e-9)


@settings(deadline=None)
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
