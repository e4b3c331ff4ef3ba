"""Means of samples and indices of them: error propagation against Monte Carlo, pairs by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.core.errors import WrongUse
from app.core.indices import NAMED
from app.core.sample_means import (
    Mean,
    covariance_of_means,
    index_of_means,
    mean_of,
    mean_of_index,
    pair_nearest,
)

NLDI, LRI = NAMED["nldi"], NAMED["lri"]


def test_a_mean_leaves_out_what_is_not_finite() -> None:
    found = mean_of(np.array([1.0, np.nan, 3.0, np.inf, 5.0]))
    assert (found.mean, found.sd, found.count) == (3.0, 2.0, 3)
    assert found.standard_error == pytest.approx(2.0 / np.sqrt(3.0))
    one, none = mean_of(np.array([4.0])), mean_of(np.array([np.nan]))
    assert (one.mean, one.count) == (4.0, 1)
    assert np.isnan([one.sd, one.standard_error, none.mean, none.standard_error]).all()
    assert none.count == 0


@pytest.mark.parametrize("name", ["nldi", "lri", "ndi", "wi", "ndvi"])
def test_the_error_of_an_index_of_means_is_what_repeating_shows(name: str) -> None:
    chance = np.random.default_rng(7)
    index, values, told = NAMED[name], [], []
    for _ in range(2000):
        a = mean_of(chance.normal(0.07, 0.01, 40))
        b = mean_of(chance.normal(0.25, 0.03, 90))
        found = index_of_means(index, a, b)
        values.append(found.value)
        told.append(found.standard_error)
    assert np.mean(told) == pytest.approx(np.std(values), rel=0.06)


@pytest.mark.parametrize("alike", [-0.6, 0.0, 0.9])
def test_channels_of_the_same_points_err_together(alike: float) -> None:
    chance, values, told = np.random.default_rng(8), [], []
    spread = np.array([[1.0, alike], [alike, 1.0]]) * np.outer([0.02, 0.03], [0.02, 0.03])
    for _ in range(2000):
        a, b = chance.multivariate_normal([0.1, 0.25], spread, 50).T
        found = index_of_means(NLDI, mean_of(a), mean_of(b), covariance_of_means(a, b))
        values.append(found.value)
        told.append(found.standard_error)
    assert np.mean(told) == pytest.approx(np.std(values), rel=0.06)


def test_points_with_one_channel_only_have_nothing_in_common() -> None:
    a, b = np.array([1.0, 2.0, 4.0, np.nan]), np.array([2.0, np.nan, 3.0, 9.0])
    both = np.cov(a[[0, 2]], b[[0, 2]])[0, 1]
    assert covariance_of_means(a, b) == pytest.approx(both * 2 / (3 * 3))
    assert covariance_of_means(a[:1], b[:1]) == 0.0


def test_the_index_of_means_is_not_the_mean_of_the_index() -> None:
    values = {"i690": np.array([0.1, 0.3]), "i1550": np.array([0.1, 0.1])}
    of_means = index_of_means(NLDI, mean_of(values["i690"]), mean_of(values["i1550"]))
    of_points = mean_of_index(NLDI, values)
    assert of_means.value == pytest.approx(0.1 / 0.3)
    assert of_points.mean == pytest.approx((0.0 + 0.5) / 2)
    assert of_points.count == 2


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_an_index_never_is_infinite(a: float, b: float) -> None:
    for index in (NLDI, LRI):
        found = index_of_means(index, Mean(a, 0.1, 9), Mean(b, 0.1, 9))
        assert not np.isinf(found.value)
        bottom = a + b if index.normalised else b
        assert np.isnan(found.value) or bottom > 0.0


def test_pairs_are_each_others_nearest() -> None:
    chance = np.random.default_rng(2)
    first, second = chance.uniform(0.0, 1.0, (300, 3)), chance.uniform(0.0, 1.0, (700, 3))
    first[5], second[9] = np.nan, np.inf
    pairs = pair_nearest(first, second, 0.08)
    far = np.linalg.norm(first[:, None] - second[None], axis=2)
    far[~np.isfinite(far)] = np.inf
    mine, theirs = far.argmin(axis=1), far.argmin(axis=0)
    wanted = [(a, b) for a, b in enumerate(mine) if theirs[b] == a and far[a, b] < 0.08]
    assert list(zip(pairs.first, pairs.second, strict=True)) == wanted
    assert pairs.distance == pytest.approx([far[pair] for pair in wanted])
    assert pairs.shares == pytest.approx((len(wanted) / 299, len(wanted) / 699))


def test_pairs_need_points_and_a_distance() -> None:
    place = np.zeros((3, 3))
    assert pair_nearest(place[:0], place, 0.1).shares == (0.0, 0.0)
    assert len(pair_nearest(place, place + 1.0, 0.1).first) == 0
    for within in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(WrongUse):
            pair_nearest(place, place, within)
