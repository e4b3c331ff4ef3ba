"""Range effects against their formulas and the figures of science.md, section 1.4."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.simulate.range_effect import Hancock, InverseSquare, NoEffect, sample_strength

SALCA = Hancock((1.98, 1.50), (0.54, 0.18), (0.64, 0.84))


@given(st.floats(0.5, 50.0))
def test_inverse_square(distance):
    effect = InverseSquare(3.56)
    assert effect.strength(np.array([3.56]), 0) == pytest.approx([1.0])
    ratio = effect.strength(np.array([2 * distance, distance]), 0)
    assert ratio[1] / ratio[0] == pytest.approx(4.0)


def test_the_inverse_square_levels_off_near_by():
    effect = InverseSquare(3.56, near=3.0)
    assert effect.strength(np.array([3.56]), 0) == pytest.approx([1.0])
    near, nearer, far, farther = effect.strength(np.array([0.1, 0.05, 50.0, 100.0]), 0)
    assert nearer / near == pytest.approx(1.0, abs=1e-3)
    assert far / farther == pytest.approx(4.0, rel=0.004)


def test_no_effect():
    np.testing.assert_array_equal(NoEffect().strength(np.array([1.0, 30.0]), 3), [1, 1])


@pytest.mark.parametrize(
    ("channel", "a", "k2", "k3"), [(0, 1.98, 0.54, 0.64), (1, 1.5, 0.18, 0.84)]
)
def test_hancock_is_the_printed_form_over_its_value_at_8_m(channel, a, k2, k3):
    def g(r):
        return r**-a * (1 - np.exp(-k2 * r)) ** k3

    ranges = np.linspace(2, 60, 30)
    np.testing.assert_allclose(SALCA.strength(ranges, channel), g(ranges) / g(8.0), rtol=1e-12)


@pytest.mark.parametrize(("channel", "low", "high"), [(0, 0.85, 1.14), (1, 0.93, 1.23)])
def test_the_other_reading_of_the_print_differs_as_science_says(channel, low, high):
    a, k2, k3 = SALCA.a[channel], SALCA.k2[channel], SALCA.k3[channel]

    def g(r):
        return r**-a * (1 - np.exp(-k2 * r**k3))

    ranges = np.linspace(2, 60, 400)
    ratio = SALCA.strength(ranges, channel) / (g(ranges) / g(8.0))
    extremes = sorted([ratio.min(), ratio.max()])
    inverse = sorted([1 / ratio.max(), 1 / ratio.min()])
    assert (
        min(
            np.abs(np.subtract(extremes, (low, high))).max(),
            np.abs(np.subtract(inverse, (low, high))).max(),
        )
        < 0.006
    )


@pytest.mark.parametrize("distance", [0.0, 1.99, 60.1, np.nan])
def test_hancock_refuses_ranges_that_were_not_calibrated(distance):
    with pytest.raises(WrongUse, match="not known"):
        SALCA.strength(np.array([5.0, distance]), 0)


def test_samples_stay_as_they_are_outside_the_calibrated_ranges():
    table = sample_strength(SALCA, 2, 80.0)
    assert table.shape == (2, 40_001)
    for channel in (0, 1):
        near, far = SALCA.strength(np.array([2.0, 60.0]), channel)
        np.testing.assert_array_equal(table[channel, :1001], near)
        np.testing.assert_array_equal(table[channel, 30_000:], far)


@pytest.mark.parametrize("near", [0.0, 3.0])
def test_samples_of_an_inverse_square_are_finite_at_the_scanner(near):
    effect = InverseSquare(3.56, near)
    (row,) = sample_strength(effect, 1, 2.0)
    assert len(row) == 1001
    np.testing.assert_allclose(row[1:], effect.strength(0.002 * np.arange(1, 1001), 0))
    assert row[0] == row[1]


def test_a_boundless_receiver_has_a_bounded_table():
    assert sample_strength(InverseSquare(3.56), 1, np.inf).shape == (1, 200_001)


@pytest.mark.parametrize(
    "make",
    [
        lambda: InverseSquare(0.0),
        lambda: InverseSquare(3.0, near=-1.0),
        lambda: Hancock((1.5,), (0.2, 0.2), (0.8,)),
        lambda: Hancock((1.5,), (-0.2,), (0.8,)),
        lambda: Hancock((1.5,), (0.2,), (0.8,), reference=1.0),
    ],
)
def test_impossible_effects_are_refused(make):
    with pytest.raises(WrongUse):
        make()
