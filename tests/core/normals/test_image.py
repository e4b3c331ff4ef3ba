"""Estimators on the range image against analytic planes, and against plain numpy."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.core.errors import BadInput, WrongUse
from app.core.incidence import incidence_angle, local_planes

ON_IMAGE = ("adaptive", "robust", "window")
ORIGIN = np.zeros(3)


def beams_of(rows, columns, down, turn, begin=0.0, lean=0.0):
    """Unit beams row by row, and their grid; the scanner leans by `lean` about x."""
    row, column = (a.ravel() for a in np.mgrid[:rows, :columns])
    elevation = begin + (row - rows // 2) * down
    azimuth = (column - columns // 2) * turn
    beams = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )
    c, s = np.cos(lean), np.sin(lean)
    beams = beams @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]).T
    return beams, SimpleNamespace(rows=rows, columns=columns, row=row, column=column)


def scan_plane(beams, normal, distance=2.0, noise=0.0, seed=0):
    """Points where beams meet the plane through (distance, 0, 0); NaN where they do not."""
    normal = np.asarray(normal) / np.linalg.norm(normal)
    with np.errstate(divide="ignore"):
        ranges = distance * normal[0] / (beams @ normal)
    ranges = np.where((ranges > 0) & (ranges < 20), ranges, np.nan)
    return beams * (ranges + np.random.default_rng(seed).normal(0, noise, len(beams)))[:, None]


def angles_of(xyz, grid, estimator="adaptive", **more):
    planes = local_planes(xyz, ORIGIN, grid=grid, estimator=estimator, **more)
    return np.rad2deg(incidence_angle(xyz, planes.normals, ORIGIN)), planes


def true_angles(beams, normal):
    normal = np.asarray(normal) / np.linalg.norm(normal)
    return np.rad2deg(np.arccos(np.clip(np.abs(beams @ normal), 0, 1)))


@pytest.mark.parametrize("estimator", ON_IMAGE)
@settings(max_examples=15, deadline=None)
@given(
    tilt=st.floats(0.0, 85.0),
    around=st.floats(0.0, 360.0),
    begin=st.floats(-60.0, 60.0),
    lean=st.floats(-20.0, 20.0),
    shape=st.sampled_from([(3e-4, 3e-4), (1.2e-3, 4.4e-3), (5e-4, -2e-4)]),
)
def test_a_plane_without_noise_is_exact(estimator, tilt, around, begin, lean, shape):
    beams, grid = beams_of(24, 30, *shape, np.deg2rad(begin), np.deg2rad(lean))
    middle = beams[grid.rows // 2 * grid.columns + grid.columns // 2]
    across = np.cross(middle, [0.3, 0.5, 0.81])
    across /= np.linalg.norm(across)
    side = np.cos(np.deg2rad(around)) * across + np.sin(np.deg2rad(around)) * np.cross(
        middle, across
    )
    normal = np.cos(np.deg2rad(tilt)) * middle + np.sin(np.deg2rad(tilt)) * side
    ranges = (middle @ normal) * 2.0 / (beams @ normal)
    xyz = beams * ranges[:, None]
    if ranges.min() <= 0.2 or ranges.max() > 10.0:
        return  # too steep for so wide a field of view
    found, planes = angles_of(xyz, grid, estimator)
    assert planes.estimator == estimator
    assert planes.method == "scan grid"
    inner = slice(12 * 30 + 10, 12 * 30 + 20)
    # Windows are small but not infinitely so: rows are arcs, and 1 / r bends over them.
    limit = 0.02 if max(map(abs, shape)) < 1e-3 else 0.3
    assert np.abs(found - true_angles(beams, normal))[inner].max() < limit
    assert ((planes.normals * xyz).sum(axis=1)[inner] < 0).all()


def regress(xyz, grid, p, half):
    """Slopes of 1 / r over the window of half-widths (rows, columns), in plain numpy."""
    ranges = np.linalg.norm(xyz, axis=1)
    near = (np.abs(grid.row - grid.row[p]) <= half[0]) & (
        np.abs(grid.column - grid.column[p]) <= half[1]
    )
    rows, columns = grid.row[near] - grid.row[p], grid.column[near] - grid.column[p]
    table = np.column_stack([np.ones(near.sum()), rows, columns])
    found, rest, *_ = np.linalg.lstsq(table, 1.0 / ranges[near], rcond=None)
    return found, rest[0] / (near.sum() - 3), np.linalg.inv(table.T @ table)


def test_the_window_is_a_plain_regression_and_its_error_too():
    step = 4e-4
    beams, grid = beams_of(40, 44, step, step)
    normal = [-0.8, 0.5, 0.2]
    xyz = scan_plane(beams, normal, noise=7e-4)
    found, planes = angles_of(xyz, grid, "window")
    ranges = np.linalg.norm(xyz, axis=1)
    for p in (15 * 44 + 15, 20 * 44 + 22, 25 * 44 + 30):
        half = int(0.004 / (ranges[p] * step) + 0.5)
        (value, by_row, by_column), square, inverse = regress(xyz, grid, p, (half, half))
        slopes = np.array([by_row, by_column]) / step
        steep = np.linalg.norm(slopes)
        assert found[p] == pytest.approx(np.rad2deg(np.arctan2(steep, value)), abs=1e-3)
        assert planes.count[p] == (2 * half + 1) ** 2
        along = slopes / steep
        variance = along @ (square * inverse[1:, 1:] / step**2) @ along
        variance *= 1 + 2 / (planes.count[p] - 3)
        sigma = np.sqrt(variance) * value / (value**2 + steep**2)
        assert planes.sigma[p] == pytest.approx(sigma, rel=0.02)


def test_noise_along_the_beam_spoils_a_ball_more_than_a_window():
    beams, grid = beams_of(90, 90, 3e-4, 3e-4)
    normal = [-np.cos(np.deg2rad(60)), np.sin(np.deg2rad(60)), 0.0]
    xyz = scan_plane(beams, normal, noise=2e-3)
    inner = (np.abs(grid.row - 45) < 30) & (np.abs(grid.column - 45) < 30)
    off = {
        name: (angles_of(xyz, grid, name)[0] - true_angles(beams, normal))[inner]
        for name in ("window", "adaptive", "ball")
    }
    spread = {name: np.sqrt(np.mean(error**2)) for name, error in off.items()}
    assert abs(np.mean(off["window"])) < 0.3
    assert abs(np.mean(off["adaptive"])) < 0.3
    assert spread["ball"] > 1.5 * spread["window"] > 2.0 * spread["adaptive"]


def test_sigma_covers_two_thirds_on_a_flat_surface():
    beams, grid = beams_of(120, 120, 3e-4, 3e-4)
    normal = [-0.8, 0.5, 0.3]
    xyz = scan_plane(beams, normal, noise=7e-4, seed=3)
    inner = (np.abs(grid.row - 60) < 40) & (np.abs(grid.column - 60) < 40)
    for name in ON_IMAGE:
        found, planes = angles_of(xyz, grid, name)
        error = np.abs(found - true_angles(beams, normal))[inner]
        assert np.mean(error < np.rad2deg(planes.sigma[inner])) == pytest.approx(0.68, abs=0.06)


def step_scan(noise=0.0):
    """A leaf at 2 m, tilted by 40°, left of column 30; a wall at 2.6 m beyond."""
    beams, grid = beams_of(60, 60, 3e-4, 3e-4)
    leaf = [-np.cos(np.deg2rad(40)), 0.0, np.sin(np.deg2rad(40))]
    front = grid.column < 30
    wall = scan_plane(beams, [-1.0, 0.0, 0.0], 2.6, noise, 1)
    xyz = np.where(front[:, None], scan_plane(beams, leaf, 2.0, noise, 2), wall)
    truth = np.where(front, true_angles(beams, leaf), true_angles(beams, [-1.0, 0.0, 0.0]))
    return xyz, grid, truth


@pytest.mark.parametrize("estimator", ON_IMAGE)
def test_points_beside_a_jump_keep_to_their_own_surface(estimator):
    xyz, grid, truth = step_scan()
    found, _ = angles_of(xyz, grid, estimator)
    assert np.abs(found - truth).max() < 0.05
    balls, _ = angles_of(xyz, grid, "ball")
    assert np.abs(balls - truth).max() < 0.05  # no mixed pixels here: a ball can do it too


def test_mixed_pixels_spoil_a_window_more_than_the_robust_ones():
    xyz, grid, truth = step_scan(2e-4)
    rng = np.random.default_rng(5)
    mixed = grid.column == 29
    away = 1.0 + rng.uniform(0.002, 0.02, mixed.sum())
    xyz[mixed] *= away[:, None]
    beside = (grid.column >= 25) & (grid.column < 29) & (np.abs(grid.row - 30) < 20)
    worst = {
        name: np.median(np.abs(angles_of(xyz, grid, name)[0] - truth)[beside])
        for name in (*ON_IMAGE, "ball")
    }
    assert worst["adaptive"] < 0.5 * worst["window"]
    assert worst["robust"] < 0.8 * worst["window"]
    assert worst["adaptive"] < 0.5 * worst["ball"]


def test_windows_grow_where_it_is_flat_and_shrink_over_waves():
    beams, grid = beams_of(120, 120, 3e-4, 3e-4)
    xyz = scan_plane(beams, [-1.0, 0.0, 0.0], 2.0)
    noise = np.random.default_rng(1).normal(0, 3e-4, len(xyz))
    waves = np.where(grid.column < 60, 0.0, 1e-3 * np.sin(grid.column * 0.6e-3 / 0.004))
    xyz = xyz * (1 + (waves + noise) / np.linalg.norm(xyz, axis=1))[:, None]
    _, planes = angles_of(xyz, grid)
    flat = (np.abs(grid.column - 28) < 12) & (np.abs(grid.row - 60) < 35)
    waved = (np.abs(grid.column - 92) < 12) & (np.abs(grid.row - 60) < 35)
    assert np.median(planes.width[flat]) > 0.007
    assert np.median(planes.width[waved]) < 0.0065
    assert np.median(planes.sigma[waved]) > 2 * np.median(planes.sigma[flat])


def full_circle(seed=0):
    """A cylinder of radius 1 m around the scanner, all around."""
    beams, grid = beams_of(40, 900, 3e-3, 2 * np.pi / 900)
    ranges = 1.0 / np.hypot(beams[:, 0], beams[:, 1])
    return beams, grid, beams * ranges[:, None]


@pytest.mark.parametrize("estimator", ON_IMAGE)
def test_windows_reach_over_the_seam(estimator):
    beams, grid, xyz = full_circle()
    found, planes = angles_of(xyz, grid, estimator, radius=0.02)
    truth = np.rad2deg(np.arctan2(np.abs(beams[:, 2]), np.hypot(beams[:, 0], beams[:, 1])))
    ends = (grid.column < 3) | (grid.column >= 897)
    ends &= np.abs(grid.row - 20) < 12  # the cylinder bends: rows at the border see it askew
    assert np.abs(found - truth)[ends].max() < 0.1
    middle = (np.abs(grid.column - 450) < 3) & (np.abs(grid.row - 20) < 12)
    assert np.median(planes.count[ends]) == np.median(planes.count[middle])


def test_points_at_a_pole_are_done_by_balls():
    beams, grid = beams_of(200, 360, np.deg2rad(0.5), np.deg2rad(1.0), np.deg2rad(40.0))
    keep = np.flatnonzero((beams[:, 2] > 0.5) & (beams[:, 2] < 1.0))
    xyz = beams[keep] / beams[keep, 2:]  # a ceiling 1 m above
    grid = SimpleNamespace(rows=200, columns=360, row=grid.row[keep], column=grid.column[keep])
    found, _ = angles_of(xyz, grid, radius=0.03)
    truth = np.rad2deg(np.arccos(beams[keep, 2]))
    high = np.rad2deg(np.arcsin(beams[keep, 2])) > 85.0
    assert high.sum() > 500
    assert np.isfinite(found[high]).mean() > 0.99
    assert np.nanmax(np.abs(found - truth)[high]) < 0.5


def test_only_what_is_asked_and_the_same_for_it():
    xyz, grid, _ = step_scan(5e-4)
    _, whole = angles_of(xyz, grid)
    asked = np.random.default_rng(0).choice(len(xyz), 300)
    part = local_planes(xyz, ORIGIN, asked, grid=grid)
    assert np.allclose(part.normals, whole.normals[asked], atol=1e-7)
    assert (part.width == whole.width[asked]).all()
    assert np.allclose(part.sigma, whole.sigma[asked], rtol=0.02)


@pytest.mark.parametrize("columns", [128 * 3 + 3, 128 * 2 + 22, 128 * 2, 70])
@pytest.mark.parametrize("estimator", ON_IMAGE)
def test_over_the_seam_too_results_are_the_same_whatever_is_asked(estimator, columns):
    beams, grid = beams_of(40, columns, 3e-3, 2 * np.pi / columns)
    noise = np.random.default_rng(0).normal(0, 1e-3, len(beams))
    xyz = beams * (1.0 / np.hypot(beams[:, 0], beams[:, 1]) + noise)[:, None]
    whole = local_planes(xyz, ORIGIN, radius=0.1, grid=grid, estimator=estimator)
    for first in (0, 90, columns - 30, columns - 2):
        asked = np.flatnonzero((grid.column >= first) & (grid.column < first + 12))
        part = local_planes(xyz, ORIGIN, asked, 0.1, grid, estimator=estimator)
        assert np.array_equal(part.normals, whole.normals[asked], equal_nan=True)
        assert np.array_equal(part.sigma, whole.sigma[asked], equal_nan=True)


def test_at_the_edge_of_a_bent_surface_windows_stay_narrow():
    beams, grid = beams_of(100, 100, 3.2e-4, 3.2e-4)
    radius, middle = 0.05, 1.55
    flat = beams[:, 0] ** 2 + beams[:, 1] ** 2
    along = beams[:, 0] * middle
    ranges = (along - np.sqrt(along**2 - flat * (middle**2 - radius**2))) / flat
    exact = beams * ranges[:, None]
    outwards = (exact - [middle, 0.0, 0.0]) * [1.0, 1.0, 0.0] / radius
    xyz = beams * (ranges + np.random.default_rng(1).normal(0, 3e-4, len(ranges)))[:, None]
    truth = np.rad2deg(np.arccos(-(beams * outwards).sum(axis=1)))
    edge = (grid.row < 8) | (grid.row > 91) | (grid.column < 8) | (grid.column > 91)
    error = {name: np.abs(angles_of(xyz, grid, name)[0] - truth)[edge] for name in ON_IMAGE}
    assert np.median(error["adaptive"]) < 1.5 * np.median(error["window"])


def test_three_points_tell_no_error():
    xyz = np.array([[2.0, 0.0, 0.0], [2.0, 5e-3, 0.0], [2.0, 0.0, 5e-3]])
    planes = local_planes(xyz, ORIGIN, radius=0.004)
    assert np.isfinite(planes.normals).all()
    assert np.isnan(planes.sigma).all()
    assert planes.balls == 3


def test_several_returns_in_a_cell_all_get_an_angle():
    xyz, grid, truth = step_scan(2e-4)
    beams, _ = beams_of(60, 60, 3e-4, 3e-4)
    behind = np.flatnonzero((grid.column > 10) & (grid.column < 25))
    second = scan_plane(beams, [-1.0, 0.2, 0.0], 2.4, 2e-4, 9)[behind]
    both = np.concatenate([xyz, second])
    twice = SimpleNamespace(
        rows=60, columns=60,
        row=np.concatenate([grid.row, grid.row[behind]]),
        column=np.concatenate([grid.column, grid.column[behind]]),
    )  # fmt: skip
    found, _ = angles_of(both, twice)
    inner = np.abs(grid.row[behind] - 30) < 20
    assert np.isfinite(found[3600:][inner]).all()
    assert np.median(np.abs(found[3600:] - true_angles(beams, [-1.0, 0.2, 0.0])[behind])[inner]) < 2
    first = (grid.column > 5) & (grid.column < 25)
    assert np.median(np.abs(found[:3600] - truth)[first]) < 1.0


def test_holes_and_spoilt_points_have_no_angle_and_harm_no_other():
    xyz, grid, truth = step_scan()
    spoilt = np.random.default_rng(2).choice(len(xyz), 400, replace=False)
    xyz[spoilt[:200]] = np.nan
    xyz[spoilt[200:300], 1] = np.inf
    xyz[spoilt[300:]] = 0.0
    found, planes = angles_of(xyz, grid)
    assert np.isnan(found[spoilt]).all()
    assert (planes.count[spoilt] == 0).all()
    assert (planes.width[spoilt] == 0).all()
    rest = np.setdiff1d(np.arange(len(xyz)), spoilt)
    assert np.nanmax(np.abs(found - truth)[rest]) < 0.05
    assert np.isfinite(found[rest]).mean() > 0.99


def test_a_cell_wider_than_ten_radii_has_no_plane():
    beams, grid = beams_of(30, 30, 0.01, 0.01)
    xyz = scan_plane(beams, [-1.0, 0.1, 0.0], 5.0)
    found, planes = angles_of(xyz, grid, radius=0.004)
    assert np.isnan(found).all()
    assert (planes.count == 0).all()


@pytest.mark.parametrize("jitter", [0.05, 0.9])
def test_a_grid_that_does_not_follow_the_beams_is_not_used_as_one(jitter):
    rng = np.random.default_rng(4)
    beams, grid = beams_of(60, 60, 3e-4, 3e-4)
    beams = beams + 3e-4 * jitter * rng.normal(size=beams.shape)
    beams /= np.linalg.norm(beams, axis=1)[:, None]
    normal = [-0.9, 0.3, 0.0]
    xyz = scan_plane(beams, normal)
    found, planes = angles_of(xyz, grid)
    assert planes.estimator == ("adaptive" if jitter < 0.1 else "ball")
    if jitter > 0.1:
        assert "follow the beams" in planes.reason
    inner = (np.abs(grid.row - 30) < 20) & (np.abs(grid.column - 30) < 20)
    assert np.median(np.abs(found - true_angles(beams, normal))[inner]) < 1.0


def test_damaged_grids_and_wrong_requests_are_refused():
    xyz, grid, _ = step_scan()
    grid = SimpleNamespace(**{**vars(grid), "row": grid.row + 1})
    with pytest.raises(BadInput, match="outside the grid"):
        local_planes(xyz, ORIGIN, grid=grid)
    with pytest.raises(BadInput, match="places"):
        local_planes(xyz[:-1], ORIGIN, grid=grid)
    with pytest.raises(WrongUse, match="estimator"):
        local_planes(xyz, ORIGIN, estimator="best")


def test_rotation_and_translation_of_all_change_no_angle():
    xyz, grid, _ = step_scan(5e-4)
    before, _ = angles_of(xyz, grid)
    turn, _ = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    for shift, limit in ((10.0, 1e-6), (1e5, 1e-6)):
        move = np.array([shift, -2 * shift, shift / 3])
        moved = xyz @ turn.T + move
        planes = local_planes(moved, move, grid=grid)
        after = np.rad2deg(incidence_angle(moved, planes.normals, move))
        assert planes.estimator == "adaptive"
        assert np.nanmax(np.abs(after - before)) < limit
