"""The peers against plain loops over all pairs of points, and on scenes with known answers."""

from __future__ import annotations

import numpy as np
import pytest

from app.model.scan import Grid, Pose, Scan
from app.services.bench.ghosts.rivals import (
    SOR_FAST,
    list_rivals,
    score_angle,
    score_outliers,
    score_sparse,
    score_step_angle,
    score_stray,
    score_window_angle,
)

STEP = 0.0005


def look(ranges, rows, columns, cells=None):
    """A scan of beams STEP apart, with those ranges row by row."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:rows, :columns])
    if cells is not None:
        row, column = row[cells], column[cells]
    side, rise = STEP * (column - columns / 2), STEP * (row - rows / 2)
    beams = np.column_stack(
        (np.cos(rise) * np.cos(side), np.cos(rise) * np.sin(side), np.sin(rise))
    )
    xyz = np.asarray(ranges)[:, None] * beams
    return Scan("s", xyz, pose=Pose((0.0, 0.0, 0.0)), grid=Grid(rows, columns, row, column))


@pytest.fixture
def rough(rng):
    """A noisy edge between 2 and 2.3 m with holes."""
    ranges = np.where(np.arange(300) % 20 < 9, 2.0, 2.3) + 0.004 * rng.standard_normal(300)
    cells = np.sort(rng.choice(300, 260, replace=False))
    return look(ranges[cells], 15, 20, cells)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def plane(degrees, rows=21, columns=21):
    """A plane 2 m away whose middle is seen at that angle."""
    scan = look(np.ones(rows * columns), rows, columns)
    turn = np.deg2rad(degrees)
    normal = np.array([np.cos(turn), np.sin(turn), 0.0])
    return scan.with_xyz(scan.xyz * (2.0 * normal[0] / (scan.xyz @ normal))[:, None])


def distances(scan):
    away = np.linalg.norm(scan.xyz[:, None] - scan.xyz[None], axis=2)
    np.fill_diagonal(away, np.inf)
    return np.sort(away, axis=1)


@pytest.mark.parametrize("balanced", [True, False])
def test_outliers_are_those_far_from_their_neighbours(rough, balanced):
    mean = distances(rough)[:, :8].mean(axis=1)
    expected = (mean - mean.mean()) / mean.std()
    np.testing.assert_allclose(score_outliers(rough, 8, balanced), expected, rtol=1e-9)


def test_a_radius_that_holds_too_few_is_one_that_the_last_lies_beyond(rough):
    away = distances(rough)
    spacing = np.median(away[:, 0])
    score = score_sparse(rough, 4)
    for radius in (1.5, 3.0, 8.0):
        few = (away < radius * spacing).sum(axis=1) < 4
        assert ((score >= radius) == few).all()


@pytest.mark.parametrize(("half", "gate"), [(3, 0.01), (2, 0.02)])
def test_the_window_counts_neighbours_that_are_there(rough, half, gate):
    own = np.linalg.norm(rough.xyz, axis=1)
    row, column = rough.grid.row, rough.grid.column
    expected = []
    for i in range(len(own)):
        inside = (abs(row - row[i]) <= half) & (abs(column - column[i]) <= half)
        inside[i] = False
        expected.append(np.mean(abs(own[inside] - own[i]) > gate) if inside.any() else 1.0)
    np.testing.assert_allclose(score_stray(rough, half, gate), expected)


def test_a_point_alone_is_a_stray_and_steep():
    scan = look(np.array([2.0]), 5, 5, np.array([12]))
    assert score_stray(scan, 2, 0.02).tolist() == [1.0]
    assert score_step_angle(scan).tolist() == [90.0]
    assert score_window_angle(scan, 1).tolist() == [90.0]


@pytest.mark.parametrize("degrees", [0.0, 30.0, 70.0, 85.0])
def test_planes_are_seen_at_their_angles(degrees):
    scan = plane(degrees)
    normal = np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees)), 0.0])
    true = np.degrees(np.arccos(abs(scan.xyz @ normal) / np.linalg.norm(scan.xyz, axis=1)))
    ways = [score_step_angle(scan), score_window_angle(scan, 1), score_window_angle(scan, 2)]
    if degrees < 80.0:  # on steeper ones the eight nearest lie in one line
        ways.append(score_angle(scan, 8))
    for found in ways:
        np.testing.assert_allclose(found, true, atol=2e-4)


def test_the_nearer_beams_keep_to_one_side_of_a_border():
    ranges = np.where(np.arange(400) % 20 < 10, 2.0, 2.5)
    angle = score_step_angle(look(ranges, 20, 20)).reshape(20, 20)
    assert angle.max() < 2.0
    window = score_window_angle(look(ranges, 20, 20), 1).reshape(20, 20)
    assert window[:, 9:11].min() > 80.0


def test_the_nearer_beams_find_a_point_between():
    ranges = np.where(np.arange(400) % 20 < 10, 2.0, 2.5)
    ranges[10::20] = 2.2
    angle = score_step_angle(look(ranges, 20, 20)).reshape(20, 20)
    assert angle[:, 10].min() > 85.0
    assert np.delete(angle, 10, axis=1).max() < 2.0


def test_rivals_have_names_of_their_own_and_scores_for_every_point(rough):
    rivals = list_rivals()
    names = [rival.name for rival in rivals]
    assert len(set(names)) == len(names)
    assert set(SOR_FAST) <= set(names)
    for rival in rivals:
        score = rival.score(rough)
        assert score.shape == (260,)
        assert np.isfinite(score).all()
