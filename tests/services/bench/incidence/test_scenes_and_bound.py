"""Scenes have the noise that they say; the bound is what a regression of 1 / range attains."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.services.bench.incidence import scenes
from app.services.bench.incidence.bound import bound_of_windows, measure_against, rms, turn_of_plane
from app.services.bench.incidence.coverage import measure_coverage
from app.services.bench.incidence.scenes import FILTERED, STRONG, USUAL, make_plane
from app.services.bench.incidence.windows import (
    half_windows,
    integrate,
    lie_undisturbed,
    sum_windows,
)


@pytest.mark.parametrize("noise", [USUAL, STRONG, FILTERED])
def test_noise_lies_along_the_beam_and_has_its_sigma(noise):
    truth = make_plane(40.0, 150)
    noisy = truth.add_noise(noise)
    before, after = (np.linalg.norm(xyz - truth.scanner, axis=1) for xyz in (truth.xyz, noisy))
    off = (after - before).reshape(150, 150)
    assert off.std() == pytest.approx(noise.sigma, rel=0.03)
    assert np.allclose(noisy / after[:, None], truth.xyz / before[:, None], atol=1e-14)
    beside = np.corrcoef(off[:, :-1].ravel(), off[:, 1:].ravel())[0, 1]
    assert beside == pytest.approx(2 / 3 if noise is FILTERED else 0.0, abs=0.03)


def test_a_plane_is_seen_at_its_angle():
    truth = make_plane(55.0, 31)
    middle = np.flatnonzero((truth.grid.row == 15) & (truth.grid.column == 15))
    assert truth.omega[middle] == pytest.approx(55.0)
    assert np.linalg.norm(truth.xyz[middle]) == pytest.approx(3.0)


def test_the_clean_scene_is_flat_leaves_alone():
    truth = scenes.make_clean(quick=True)
    assert truth.judged.all()
    assert (truth.leaf >= 0).all()
    leaf = truth.xyz[truth.leaf == 100]
    thin = np.linalg.svd(leaf - leaf.mean(axis=0), compute_uv=False)[2]
    assert thin < 1e-9


def test_the_hard_scene_judges_true_leaf_points_of_all_kinds():
    truth = scenes.make_hard(0.15, "hard")
    assert set(np.unique(truth.kind[truth.judged])) == {0, 1, 2}
    assert (truth.leaf[truth.judged] >= 0).all()
    assert 0.2 < truth.judged.mean() < 0.8
    assert ((truth.leaf >= 0) & ~truth.judged).any()  # mixed pixels are there, and not judged


def test_windows_are_summed_and_cut_at_the_border():
    truth = make_plane(10.0, 20)
    total = integrate(np.ones((20, 20)))
    high, wide = half_windows(truth, np.full(400, 0.004))
    assert set(high) <= {3, 4, 5}
    found = sum_windows(total, truth, high, wide).reshape(20, 20)
    assert found[10, 10] == (2 * high[210] + 1) * (2 * wide[210] + 1)
    assert found[0, 0] == (high[0] + 1) * (wide[0] + 1)
    quiet = lie_undisturbed(truth, np.full(400, 0.004)).reshape(20, 20)
    assert quiet[10, 10]
    assert not quiet[0, 0]


def test_a_point_beside_another_leaf_is_disturbed():
    truth = make_plane(10.0, 30)
    truth.leaf[truth.grid.column >= 15] = 1
    quiet = lie_undisturbed(truth, np.full(900, 0.004)).reshape(30, 30)
    assert quiet[15, 8]
    assert not quiet[15, 13]
    assert not quiet[15, 16]


@pytest.mark.parametrize("degrees", [20.0, 50.0, 75.0])
def test_the_bound_is_that_of_a_regression(degrees):
    """Weighted least squares through one window, again and again, reaches it within 3 %."""
    side, half = 21, 4
    truth = make_plane(degrees, side)
    middle = side * side // 2
    away = np.linalg.norm(truth.xyz, axis=1)
    beams = truth.xyz / away[:, None]
    width = half * np.deg2rad(0.018) * away
    bound = bound_of_windows(truth, USUAL.sigma, width, np.full(len(away), (2 * half + 1) ** 2))
    rows, columns = truth.grid.row - side // 2, truth.grid.column - side // 2
    window = (np.abs(rows) <= half) & (np.abs(columns) <= half)
    random = np.random.default_rng(0)
    noisy = away[window] + random.normal(0, USUAL.sigma, (4000, window.sum()))
    weight = away[window] ** 2
    solve = np.linalg.pinv(beams[window] * weight[:, None])
    planes = (weight / noisy) @ solve.T
    along = planes @ beams[middle]
    across = np.linalg.norm(np.cross(planes, beams[middle]), axis=1)
    error = np.arctan2(across, along) - np.deg2rad(truth.omega[middle])
    assert rms(error) == pytest.approx(bound[middle], rel=0.03)


def test_the_angle_turns_as_the_plane_does():
    truth = make_plane(35.0, 9)
    away = np.linalg.norm(truth.xyz, axis=1)
    beams = truth.xyz / away[:, None]
    plane = np.linalg.lstsq(beams, 1 / away, rcond=None)[0]
    gradient = turn_of_plane(beams, away)

    def angle(m):
        return np.arctan2(np.linalg.norm(np.cross(beams, m), axis=1), beams @ m)

    for axis in np.eye(3):
        slope = (angle(plane + 1e-6 * axis) - angle(plane - 1e-6 * axis)) / 2e-6
        assert np.allclose(gradient @ axis, slope, atol=1e-6)


def test_windows_that_were_not_used_have_no_bound():
    truth = make_plane(35.0, 21)
    width = np.full(441, 0.004)
    assert np.isnan(bound_of_windows(truth, 0.001, width, np.full(441, 7.0))).all()


def test_our_windows_are_near_the_bound():
    against = measure_against("window", USUAL, quick=True)
    assert against.known > 0.7
    assert 0.9 < against.whole < 1.1


def test_coverage_is_told_by_kind_and_place():
    rows = measure_coverage(make_plane(40.0, 120), (USUAL,))
    assert {row["points"] for row in rows} == {"all", "undisturbed"}
    assert all(0 <= row["within 1 σ"] <= row["within 2 σ"] <= 1 for row in rows)
    whole = next(r for r in rows if r["points"] == "all" and r["where"] == "away from the pole")
    assert 0.5 < whole["within 1 σ"] < 0.85


def test_scans_of_the_other_simulator_must_be_there(tmp_path):
    with pytest.raises(BadInput):
        scenes.read_other(tmp_path, "pulsed")


@pytest.mark.data
def test_scans_of_the_other_simulator_are_read(shared_data):
    truth = scenes.read_other(shared_data / "truth_scenes", "phase_shift")
    assert truth.add_noise(scenes.GIVEN) is truth.xyz
    assert 100_000 < truth.judged.sum() < len(truth.xyz)
    assert set(np.unique(truth.kind[truth.judged])) == {0, 1, 2}
