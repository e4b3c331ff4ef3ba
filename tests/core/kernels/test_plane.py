"""The plane solver against numpy's eigen solver, at all shapes and sizes of point sets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.core.kernels.plane import LANES, PLANES, SUMS, smallest_axis, solve_lanes

SCANNER = np.zeros(3)
UPPER = np.triu_indices(3)


def make_patches(rng, spreads, offset=0.0, size=40):
    """`LANES` sets of points that spread by `spreads` along random axes; (LANES, size, 3)."""
    turns = np.linalg.qr(rng.normal(size=(LANES, 3, 3)))[0]
    return (rng.normal(size=(LANES, size, 3)) * spreads + offset) @ turns


def sum_up(patches):
    sums = np.empty((SUMS, LANES))
    sums[0] = patches.shape[1]
    sums[1:4] = patches.sum(axis=1).T
    sums[4:] = (patches.transpose(0, 2, 1) @ patches)[:, *UPPER].T
    return sums


def solve(sums, width, distance=3.0):
    own = np.zeros((3, LANES))
    own[0] = distance
    planes = np.empty(PLANES * LANES)
    solve_lanes(sums.ravel(), own.ravel(), SCANNER, width, planes)
    found = planes.reshape(PLANES, LANES)
    return found[:3].T, found[3], found[4] > 0, found[5] > 0


def covariance(sums):
    mean = sums[1:4] / sums[0]
    upper = sums[4:] / sums[0] - mean[UPPER[0]] * mean[UPPER[1]]
    full = np.zeros((LANES, 3, 3))
    full[:, *UPPER] = upper.T
    return full + np.triu(full, 1).transpose(0, 2, 1)


def degrees_between(a, b):
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.rad2deg(np.arctan2(across, np.abs((a * b).sum(axis=1))))


@settings(max_examples=80, deadline=None)
@given(
    st.integers(0, 10**6),
    st.floats(0.0, 1.0), st.floats(0.0, 1.0),
    st.sampled_from([1e-60, 1e-9, 1e-3, 1.0, 1e6, 1e30]),
    st.sampled_from([0.0, 1.0, 30.0]),
)  # fmt: skip
@example(seed=1794, thin=0.0, narrow=0.0, scale=1e-9, offset=1.0)  # Newton lands on λ₃
def test_equals_the_eigen_solver(seed, thin, narrow, scale, offset):
    spreads = scale * np.array([thin * narrow, narrow, 1.0])
    sums = sum_up(make_patches(np.random.default_rng(seed), spreads, offset * scale * 0.1))
    normals, rms, _, sound = solve(sums, 4.0 * scale, 3.0 * scale)
    matrices = covariance(sums)
    values, vectors = np.linalg.eigh(matrices)
    sharp = values[:, 1] > 10.0 * np.maximum(values[:, 0], 0.0)
    apart = degrees_between(normals, vectors[:, :, 0])
    assert (apart[sharp & sound] < 1e-6).all()
    assert (apart[sound] < 1e-4).all()
    assert np.allclose(np.linalg.norm(normals[sound], axis=1), 1.0, atol=1e-12)
    assert np.allclose(rms[sound] ** 2, values[sound, 0], atol=1e-12 * values[:, 2].max())
    for k in np.flatnonzero(sharp & (values[:, 1] > 1e-9 * values[:, 2])):
        a, d, e, b, f, c = matrices[k][UPPER]
        careful = smallest_axis(a, d, e, b, f, c)
        assert degrees_between(np.array([careful[:3]]), vectors[k : k + 1, :, 0])[0] < 1e-5
        assert np.allclose(careful[3:], values[k], atol=1e-13 * values[k, 2])


def test_ordinary_patches_need_no_second_try():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        sums = sum_up(make_patches(rng, np.array([0.7, rng.uniform(1.2, 2.0), 2.0]) * 1e-3))
        normals, _, covers, sound = solve(sums, 0.004)
        assert sound.mean() > 0.9
        assert covers.all()
        assert (normals[:, 0] <= 0.0).all()  # they face the scanner


@pytest.mark.parametrize(
    "spreads", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1e-9, 1e-9, 1.0), (1.0, 1.0, 1.0)]
)
def test_no_clear_plane_is_left_to_the_careful_way(spreads):
    rng = np.random.default_rng(5)
    sums = sum_up(make_patches(rng, np.array(spreads), size=100_000))
    assert not solve(sums, 4.0)[3].any()


def test_few_points_and_rounding_of_large_coordinates():
    sums = sum_up(make_patches(np.random.default_rng(6), np.array([0.0, 1e-9, 1e-9])))
    assert not solve(sums, 4e-9, distance=1e7)[3].any()
    sums[0] = 2.0
    assert not solve(sums, 4e-9)[2].any()


def test_a_line_across_the_beam_covers_no_area():
    """Its noise along the beam must not pass for a second direction."""
    rng = np.random.default_rng(7)
    line = rng.normal(size=(LANES, 30, 3)) * [2e-3, 1e-6, 2e-3]
    assert not solve(sum_up(line), 0.004)[2].any()
    line = rng.normal(size=(LANES, 30, 3)) * [2e-3, 1e-3, 2e-3]
    assert solve(sum_up(line), 0.004)[2].all()
