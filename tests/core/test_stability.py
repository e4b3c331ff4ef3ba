"""What must not change an angle of incidence does not; the bench prints the same cases."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.services.bench.stability import changes
from app.services.bench.stability.run import list_cases
from app.services.bench.stability.ways import WAYS

SIDE = 48
CASES = [pytest.param(case, id=f"{case.group}-{case.name}") for case in list_cases()]
ways = pytest.mark.parametrize("way", WAYS, ids=lambda way: way.name)
seeds = st.integers(0, 10**6)


@ways
@pytest.mark.parametrize("case", CASES)
def test_case(case, way):
    outcome = case.run(way, SIDE)
    assert outcome.compared > 0
    assert outcome.worst <= case.limit


@ways
@pytest.mark.parametrize("change", [changes.turn, changes.mirror, changes.shuffle])
@settings(max_examples=8)
@given(seed=seeds)
def test_turning_mirroring_and_shuffling_change_no_angle(way, change, seed):
    assert change(way, 32, seed=seed).worst <= changes.EXACT


@ways
@settings(max_examples=8)
@given(seed=seeds, offset=st.floats(1.0, 1e6))
def test_moving_changes_no_angle(way, seed, offset):
    assert changes.shift(way, 32, offset=offset, seed=seed).worst <= changes.EXACT


@ways
@settings(max_examples=8)
@given(seed=seeds, power=st.floats(-3.0, 3.0))
def test_scaling_changes_no_angle(way, seed, power):
    assert changes.scale(way, 32, factor=10.0**power, seed=seed).worst <= changes.EXACT
