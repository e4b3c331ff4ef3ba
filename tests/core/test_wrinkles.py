from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from app.core.errors import BadInput
from app.core.wrinkles import (
    BIN,
    SIGN_OF_DELTA,
    delta_omega,
    distribution,
)


def degrees(*values: float) -> np.ndarray:
    return np.deg2rad(np.array(values))


def test_positive_is_towards_edge_on_and_the_legend_says_so() -> None:
    delta = delta_omega(degrees(10.0, 30.0, 70.0, np.nan), np.deg2rad(30.0))
    np.testing.assert_allclose(np.rad2deg(delta), [-20.0, 0.0, 40.0, np.nan], atol=1e-12)
    assert "positive is turned towards edge-on (blue" in SIGN_OF_DELTA
    assert "negative is turned towards the beam" in SIGN_OF_DELTA


def test_statistics_agree_with_scipy() -> None:
    delta = np.random.default_rng(3).gamma(2.0, 0.05, 5000) - 0.1
    with_gaps = np.concatenate([delta, [np.nan, np.inf]])
    result = distribution(with_gaps)
    assert (result.count, result.undefined) == (5000, 2)
    assert result.mean == pytest.approx(delta.mean())
    assert result.median == pytest.approx(np.median(delta))
    assert result.sd == pytest.approx(stats.tstd(delta) * np.sqrt(4999 / 5000))
    assert result.skewness == pytest.approx(stats.skew(delta))
    np.testing.assert_allclose(
        result.quantiles, stats.scoreatpercentile(delta, [5, 25, 75, 95]), rtol=1e-12
    )


def test_histogram_is_normalised_and_on_whole_degrees() -> None:
    delta = np.random.default_rng(4).normal(0.05, 0.1, 1000)
    result = distribution(delta)
    expected, _ = np.histogram(delta, result.edges)
    np.testing.assert_array_equal(np.rint(result.fraction * 1000), expected)
    assert result.fraction.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(result.edges / BIN, np.rint(result.edges / BIN), atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("n", [60, 3000])
def test_a_plain_leaf_has_one_mode(seed: int, n: int) -> None:
    delta = np.random.default_rng(seed).normal(0.0, np.deg2rad(6.0), n)
    result = distribution(delta)
    assert len(result.modes) == 1
    assert abs(result.modes[0]) < np.deg2rad(4.5)


@pytest.mark.parametrize("seed", range(5))
def test_two_sides_of_a_wrinkle_are_two_modes_the_higher_first(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sides = rng.normal(-0.2, 0.05, 700), rng.normal(0.2, 0.05, 1500)
    modes = distribution(np.concatenate(sides)).modes
    np.testing.assert_allclose(modes, [0.2, -0.2], atol=np.deg2rad(2.0))


def test_simple_curvature_is_one_skewed_mode() -> None:
    delta = stats.gamma(3.0, scale=0.05).rvs(4000, random_state=5)
    result = distribution(delta)
    assert len(result.modes) == 1
    assert result.skewness > 0.8
    assert result.modes[0] < result.median < result.mean


def test_equal_values() -> None:
    result = distribution(np.full(10, 0.1))
    assert result.sd == pytest.approx(0.0, abs=1e-15)
    assert np.isnan(result.skewness)
    assert len(result.modes) == 1
    assert result.fraction.tolist() == [1.0]


def test_nothing_to_describe_is_refused() -> None:
    with pytest.raises(BadInput, match="Δω"):
        distribution(np.full(3, np.nan))
