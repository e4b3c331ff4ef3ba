"""Offsets: added on a logarithmic scale, a factor on a linear one, and one as the other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.core.wrinkling.offset import Offset, find_factor, no_offset, scatter_of

VALUES = np.array([0.05, 0.2, 0.4])


@given(st.floats(0.01, 100.0), st.floats(10.0, 1000.0))
def test_a_shift_of_dn_is_a_factor_of_reflectance(factor, per_decade):
    shift = per_decade * np.log10(factor)
    dn = per_decade * np.log10(VALUES)
    assert np.allclose(Offset("added", shift).apply(dn), per_decade * np.log10(factor * VALUES))
    assert find_factor(shift, per_decade) == pytest.approx(factor)


def test_fifty_dn_of_the_ls880_are_a_fifth_more_light():
    assert find_factor(50.0, 600.0) == pytest.approx(10 ** (50 / 600))


@pytest.mark.parametrize("offset", [Offset("added", 50.0, 3.0), Offset("factor", 1.2, 0.1)])
def test_what_is_applied_is_removed(offset):
    assert np.allclose(offset.remove(offset.apply(VALUES)), VALUES)


def test_errors_of_an_offset():
    assert np.allclose(Offset("added", 5.0, 3.0).sigma_of(VALUES), 3.0)
    assert np.allclose(Offset("factor", 2.0, 0.2).sigma_of(VALUES), 0.1 * VALUES)
    assert np.allclose(no_offset("linear").sigma_of(VALUES), 0.0)
    assert no_offset("log").apply(VALUES) is not VALUES


def test_scatter_of_reflectance_on_both_scales():
    assert scatter_of(0.08, "linear", None) == Offset("factor", 1.0, 0.08)
    dn = scatter_of(0.08, "log", 600.0)
    assert dn.kind == "added"
    # d(600 log10 ρ) = 600 / ln 10 · dρ/ρ
    assert dn.sigma == pytest.approx(600 * 0.08 / np.log(10))


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Offset("factor", 0.0),
        lambda: Offset("factor", -1.0),
        lambda: Offset("added", np.nan),
        lambda: Offset("added", 0.0, -1.0),
        lambda: Offset("added", 0.0, np.inf),
        lambda: find_factor(50.0, 0.0),
        lambda: scatter_of(0.08, "log", None),
        lambda: scatter_of(0.08, "log", np.nan),
    ],
)
def test_what_is_no_offset_is_refused(wrong):
    with pytest.raises(WrongUse):
        wrong()
