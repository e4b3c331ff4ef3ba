"""The leaf's plane for noise along the beam: exact, unbiased when steep, robust, moved, with σ."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.inverse_plane import inverse_range_plane
from app.core.planes import leaf_plane, robust_plane, total_least_squares_plane

SCANNER = np.array([0.3, -0.2, 1.6])
STEP = np.deg2rad(0.018)


def scan_leaf(tilt, noise=0.0, seed=0, radius=0.035, distance=2.5, bend=0.0):
    """A round leaf met at `tilt` degrees, bent about the vertical, and its normal.

    Beams are 0.018° apart; a bent leaf is found by Newton's method along each beam.
    """
    turn = np.deg2rad(tilt)
    normal = np.array([-np.cos(turn), np.sin(turn), 0.0])
    along = np.array([np.sin(turn), np.cos(turn), 0.0])
    half = int(radius / distance / STEP) + 1
    angle = np.arange(-half, half + 1) * STEP
    up, side = (t.ravel() for t in np.meshgrid(angle, angle, indexing="ij"))
    beams = np.stack([np.cos(up) * np.cos(side), np.cos(up) * np.sin(side), np.sin(up)], axis=1)
    centre = np.array([distance, 0.0, 0.0])
    away = distance * normal[0] / (beams @ normal)
    for _ in range(20):
        offset = away[:, None] * beams - centre
        place = offset @ along
        height = offset @ normal - bend / 2 * place**2
        away = away - height / (beams @ normal - bend * place * (beams @ along))
    offset = away[:, None] * beams - centre
    on = np.hypot(offset @ along, offset[:, 2]) < radius
    noisy = away[on] + np.random.default_rng(seed).normal(0.0, noise, on.sum())
    return noisy[:, None] * beams[on] + SCANNER, normal


def error_of(plane, normal):
    """Estimated minus true angle, degrees, for the beam to the plane's point."""
    beam = plane.point - SCANNER
    true = np.arctan2(np.linalg.norm(np.cross(beam, normal)), abs(beam @ normal))
    return np.degrees(plane.incidence - true)


@pytest.mark.parametrize("tilt", [0.0, 1.0, 30.0, 60.0, 85.0])
def test_a_plane_without_noise_is_exact(tilt):
    xyz, normal = scan_leaf(tilt)
    plane = inverse_range_plane(xyz, SCANNER)
    assert abs(plane.normal @ normal) == pytest.approx(1.0, abs=1e-12)
    assert plane.normal @ (SCANNER - plane.point) > 0.0
    assert plane.method == "inverse range"
    assert plane.outlier_share == 0.0
    assert plane.sigma < 1e-9


@pytest.mark.parametrize("tilt", [45.0, 60.0, 75.0])
def test_noise_along_the_beam_turns_the_others_but_not_this(tilt):
    errors = {fit: [] for fit in (inverse_range_plane, total_least_squares_plane, leaf_plane)}
    for seed in range(12):
        xyz, normal = scan_leaf(tilt, 0.0026, seed)
        for fit, found in errors.items():
            found.append(error_of(fit(xyz, SCANNER), normal))
    bias = {fit: abs(np.mean(found)) for fit, found in errors.items()}
    assert bias[inverse_range_plane] < 0.05
    assert bias[total_least_squares_plane] > 0.25
    assert bias[leaf_plane] > 0.25


@pytest.mark.parametrize("tilt", [20.0, 70.0])
def test_it_is_the_least_squares_of_the_ranges(tilt):
    scipy = pytest.importorskip("scipy.optimize")
    xyz, _ = scan_leaf(tilt, 0.0007)
    local = xyz - SCANNER
    away = np.linalg.norm(local, axis=1)
    beams = local / away[:, None]
    start = np.linalg.lstsq(beams, 1.0 / away, rcond=None)[0]

    def off(m):
        return 1.0 / (beams @ m) - away

    kept = np.abs(off(start)) < 3.0 * 0.0007
    best = scipy.least_squares(lambda m: off(m)[kept], start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    plane = inverse_range_plane(xyz, SCANNER)
    assert np.degrees(
        np.arccos(min(abs(plane.normal @ best) / np.linalg.norm(best), 1.0))
    ) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("tilt", [0.0, 40.0, 70.0])
@pytest.mark.parametrize("fit", [inverse_range_plane, robust_plane])
def test_ghosts_behind_the_rim_do_not_turn_it(fit, tilt):
    xyz, normal = scan_leaf(tilt, 0.0007)
    local = xyz - SCANNER
    rim = np.flatnonzero(np.linalg.norm(local - local.mean(axis=0), axis=1) > 0.03)
    factor = np.random.default_rng(2).uniform(1.05, 1.9, (len(rim), 1))
    plane = fit(np.concatenate((xyz, local[rim] * factor + SCANNER)), SCANNER)
    assert abs(error_of(plane, normal)) < 0.3
    assert plane.outlier_share > 0.05
    assert "farther" in plane.warning


def test_a_bent_leaf_has_its_mean_plane():
    xyz, normal = scan_leaf(55.0, 0.0007, bend=10.0)
    plane = inverse_range_plane(xyz, SCANNER)
    assert plane.method == "inverse range, bent"
    local = xyz - SCANNER
    flat = np.linalg.lstsq(local, np.ones(len(xyz)), rcond=None)[0]
    beam = local.mean(axis=0)
    steep = np.linalg.norm(np.cross(beam, flat)) / (beam @ flat)
    assert abs(error_of(plane, normal)) < 2.0 < abs(np.degrees(np.arctan(steep)) - 55.0)
    assert np.degrees(plane.sigma) > 0.2  # it has no one angle
    flat = inverse_range_plane(scan_leaf(55.0, 0.0007)[0], SCANNER)
    assert np.degrees(flat.sigma) < 0.1


@pytest.mark.parametrize("tilt", [15.0, 50.0, 75.0])
@pytest.mark.parametrize("shared", [False, True])
def test_the_true_angle_lies_within_sigma_two_times_in_three(tilt, shared):
    within = []
    for seed in range(40):
        xyz, normal = scan_leaf(tilt, 0.0, seed, 0.025)
        local = xyz - SCANNER
        away = np.linalg.norm(local, axis=1)
        noise = np.random.default_rng(seed).normal(0.0, 0.0007, len(xyz))
        if shared:  # neighbours along a row have the same noise, three at a time
            noise = np.repeat(noise[::3], 3)[: len(xyz)]
        plane = inverse_range_plane(xyz + local * (noise / away)[:, None], SCANNER)
        within.append(abs(error_of(plane, normal)) <= np.degrees(plane.sigma))
    assert 0.48 < np.mean(within) < 0.88


def test_the_rim_is_left_out():
    xyz, normal = scan_leaf(60.0, 0.0007)
    local = xyz - SCANNER
    away = np.linalg.norm(local, axis=1, keepdims=True)
    beams = local / away
    row = np.round(np.arcsin(beams[:, 2]) / STEP).astype(int)
    added = []
    for one in np.unique(row):  # beams beyond the rim, at its range: as a wide beam has it
        mine = np.flatnonzero(row == one)
        for end in (mine[np.argmin(beams[mine, 1])], mine[np.argmax(beams[mine, 1])]):
            out = np.sign(beams[end, 1]) * STEP * np.arange(1, 4)[:, None] * [0.0, 1.0, 0.0]
            added.append((beams[end] + out) * away[end])
    spoilt = np.concatenate([local, *added]) + SCANNER
    whole = error_of(inverse_range_plane(spoilt, SCANNER), normal)
    inside = error_of(inverse_range_plane(spoilt, SCANNER, rim=4 * STEP), normal)
    assert whole < -0.2
    assert abs(inside) < 0.1


def test_a_rim_that_would_leave_nothing_is_kept():
    xyz, _ = scan_leaf(60.0, 0.0007)
    plain = inverse_range_plane(xyz, SCANNER)
    assert inverse_range_plane(xyz, SCANNER, rim=0.05).incidence == plain.incidence


def test_far_coordinates_and_missing_rows_change_nothing():
    xyz, _ = scan_leaf(50.0, 0.0007)
    shift = np.array([4e5, 5.6e6, 100.0])
    here = inverse_range_plane(xyz, SCANNER)
    far = inverse_range_plane(np.insert(xyz, 5, np.nan, axis=0) + shift, SCANNER + shift)
    assert far.incidence == pytest.approx(here.incidence, abs=1e-6)
    assert far.sigma == pytest.approx(here.sigma, rel=1e-3)


def test_a_turn_of_everything_changes_nothing():
    xyz, _ = scan_leaf(50.0, 0.0007)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    here = inverse_range_plane(xyz, SCANNER)
    there = inverse_range_plane(xyz @ turn.T, turn @ SCANNER)
    assert there.incidence == pytest.approx(here.incidence, abs=1e-9)
    assert there.sigma == pytest.approx(here.sigma, rel=0.3)  # its blocks are others


@pytest.mark.parametrize("fit", [inverse_range_plane, robust_plane])
def test_what_has_no_plane_is_refused(fit):
    line = np.outer(np.linspace(0, 1, 30), [1.0, 2.0, 3.0]) + 5.0
    for xyz, text in ((line, "one line"), (line[:2], "three points"), (line * np.nan, "0 of")):
        with pytest.raises(BadInput, match=text):
            fit(xyz, SCANNER)
    crown = np.random.default_rng(5).normal((5.0, 0.0, 2.0), (0.5, 0.4, 0.6), (3000, 3))
    with pytest.raises(BadInput, match="all directions"):
        fit(crown, SCANNER)


def test_few_points_have_a_plane_and_no_sigma():
    xyz, normal = scan_leaf(30.0)
    plane = inverse_range_plane(xyz[[0, 10, len(xyz) // 2, len(xyz) // 2 + 9, -1]], SCANNER)
    assert abs(plane.normal @ normal) == pytest.approx(1.0, abs=1e-9)
    assert np.isnan(plane.sigma)
