"""Leaf planes: three regressions against numpy, and what must be refused."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import BadInput
from app.core.planes import (
    leaf_plane,
    regression_plane,
    robust_plane,
    total_least_squares_plane,
)


def make_leaf(normal, noise=0.0, n=400, offset=(2.0, 0.3, 0.1), seed=0):
    rng = np.random.default_rng(seed)
    normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    u, v = np.linalg.svd(normal[None])[2][1:]
    flat = rng.uniform(-0.03, 0.03, (n, 2)) @ np.stack([u, v])
    return flat + rng.normal(0, noise, n)[:, None] * normal + np.asarray(offset), normal


@pytest.mark.parametrize("normal", [(-1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 2, 0.5)])
@pytest.mark.parametrize(
    "fit", [leaf_plane, regression_plane, robust_plane, total_least_squares_plane]
)
def test_exact_plane(normal, fit):
    xyz, truth = make_leaf(normal)
    plane = fit(xyz, np.zeros(3))
    assert abs(plane.normal @ truth) == pytest.approx(1.0, abs=1e-12)
    assert plane.normal @ plane.point < 0
    assert plane.rmse < 1e-12
    assert plane.outlier_share == 0.0
    beam = plane.point / np.linalg.norm(plane.point)
    assert plane.incidence == pytest.approx(np.arccos(abs(beam @ truth)), abs=1e-9)


def test_smallest_regression_wins():
    xyz, _ = make_leaf((-1, 0.4, 0.3), noise=0.001)
    rmse = {}
    for axis, name in ((2, "z on x,y"), (1, "y on x,z"), (0, "x on y,z")):
        design = np.column_stack([np.delete(xyz, axis, axis=1), np.ones(len(xyz))])
        solution = np.linalg.lstsq(design, xyz[:, axis], rcond=None)[0]
        rmse[name] = np.sqrt(np.mean((xyz[:, axis] - design @ solution) ** 2))
    best = min(rmse, key=rmse.get)
    plane = leaf_plane(xyz, None)
    assert plane.method == f"LSR {best}"
    assert plane.rmse == pytest.approx(rmse[best], rel=1e-9)
    assert np.isnan(plane.incidence)


def test_bent_leaf_is_kept_with_a_warning():
    xyz, _ = make_leaf((0, 0, 1))
    xyz[:, 2] += 15.0 * (xyz[:, 0] - 2.0) ** 2
    plane = leaf_plane(xyz, np.zeros(3), d_l=0.002)
    assert plane.outlier_share > 0.05
    assert "farther than 0.002 m" in plane.warning


def test_missing_rows_and_large_offsets_change_nothing():
    xyz, _ = make_leaf((-1, 0.4, 0.3), noise=0.0005)
    with_gap = np.insert(xyz, 5, np.nan, axis=0)
    shift = np.array([4e5, 5.6e6, 100.0])
    a, b = leaf_plane(xyz, np.zeros(3)), leaf_plane(with_gap + shift, shift)
    assert b.normal == pytest.approx(a.normal, abs=1e-7)
    assert b.incidence == pytest.approx(a.incidence, abs=1e-7)


@pytest.mark.parametrize(
    "fit", [leaf_plane, regression_plane, robust_plane, total_least_squares_plane]
)
def test_points_without_a_plane_are_refused(fit):
    line = np.outer(np.linspace(0, 1, 30), [1.0, 2.0, 3.0]) + 1e6
    for xyz, text in ((line, "one line"), (line[:2], "three points"), (line * np.nan, "0 of")):
        with pytest.raises(BadInput, match=text):
            fit(xyz, None)
    with pytest.raises(BadInput, match="one line"):
        fit(np.repeat(line[:1], 9, axis=0), None)


def tilted_leaf(tilt: float, seed: int = 1) -> np.ndarray:
    """A flat leaf 3 m ahead, turned by `tilt` degrees, with 0.7 mm of range noise."""
    random = np.random.default_rng(seed)
    across, up = random.uniform(-0.02, 0.02, 800), random.uniform(-0.04, 0.04, 800)
    angle = np.radians(tilt)
    xyz = np.stack((3.0 + across * np.sin(angle), across * np.cos(angle), up), axis=1)
    return xyz + random.normal(0, 0.0007, (800, 1)) * (1.0, 0.0, 0.0)


@pytest.mark.parametrize("tilt", [0, 30, 45, 60])
def test_ghosts_behind_the_rim_do_not_turn_the_plane(tilt: float) -> None:
    leaf = tilted_leaf(tilt)
    ghosts = leaf[:240] * np.random.default_rng(2).uniform(1.05, 1.9, (240, 1))
    plane = leaf_plane(np.concatenate((leaf, ghosts)), np.zeros(3))
    assert plane.method == "robust"
    assert plane.warning
    alone = leaf_plane(leaf, np.zeros(3))
    assert alone.method.startswith("LSR")
    assert np.degrees(plane.incidence) == pytest.approx(np.degrees(alone.incidence), abs=1.0)


def test_the_robust_plane_is_the_same_every_time() -> None:
    leaf = np.concatenate((tilted_leaf(40), tilted_leaf(40)[:300] * 1.4))
    first, second = (leaf_plane(leaf, np.zeros(3)) for _ in range(2))
    assert (first.normal == second.normal).all()


@pytest.mark.parametrize("noise", [0.0, 1e-7, 0.0007])
def test_a_line_has_no_plane_however_noisy(noise: float) -> None:
    random = np.random.default_rng(4)
    line = np.linspace(0, 0.07, 73)[:, None] * (0.3, 0.5, 0.8) + (2.0, 1.0, 0.5)
    with pytest.raises(BadInput, match="line"):
        leaf_plane(line + random.normal(0, noise, line.shape), np.zeros(3))


def test_a_crown_has_no_plane() -> None:
    crown = np.random.default_rng(5).normal((5.0, 0.0, 2.0), (0.5, 0.4, 0.6), (3000, 3))
    with pytest.raises(BadInput, match="all directions"):
        leaf_plane(crown, np.zeros(3))


def test_each_plane_is_what_leaf_plane_takes() -> None:
    leaf = tilted_leaf(40)
    ghosts = leaf[:240] * np.random.default_rng(2).uniform(1.05, 1.9, (240, 1))
    spoilt = np.concatenate((leaf, ghosts))
    for xyz, fit in ((leaf, regression_plane), (spoilt, robust_plane)):
        taken, own = leaf_plane(xyz, np.zeros(3)), fit(xyz, np.zeros(3))
        assert taken.method == own.method
        assert (taken.normal == own.normal).all()
        assert taken.sigma == own.sigma
    assert regression_plane(spoilt, np.zeros(3)).warning


@pytest.mark.parametrize("fit", [regression_plane, robust_plane, total_least_squares_plane])
@pytest.mark.parametrize("tilt", [10, 60])
def test_sigma_is_the_spread_of_the_angle(fit, tilt) -> None:
    planes = [fit(tilted_leaf(tilt, seed), np.zeros(3)) for seed in range(60)]
    # Each draw has its own points: what is left of the mean angle is small beside the noise.
    spread = np.std([plane.incidence for plane in planes])
    assert np.median([plane.sigma for plane in planes]) == pytest.approx(spread, rel=0.35)


def test_without_a_scanner_there_is_no_sigma() -> None:
    assert np.isnan(leaf_plane(tilted_leaf(10), None).sigma)
