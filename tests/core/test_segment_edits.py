"""Cuts through leaves by seeds."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.segment_edits import split_points


def make_strip():
    x, y = (a.ravel() for a in np.mgrid[:40, :5])
    return np.stack([x, y, 0 * x], axis=1) * 0.001


def test_seeds_cut_in_the_middle_between_them():
    xyz = make_strip()
    owner = split_points(xyz, [np.array([2]), np.array([len(xyz) - 3])])
    assert set(owner[xyz[:, 0] < 0.019]) == {0}
    assert set(owner[xyz[:, 0] > 0.021]) == {1}


def test_more_seeds_move_the_cut():
    xyz = make_strip()
    near = [np.array([2, 27 * 5 + 2]), np.array([len(xyz) - 3])]
    owner = split_points(xyz, near)
    assert set(owner[xyz[:, 0] < 0.032]) == {0}
    assert set(owner[xyz[:, 0] > 0.034]) == {1}


def test_the_way_goes_along_the_surface():
    """Two arms of a U lie nearer to each other than their ends do along the bend."""
    turn = np.linspace(0, np.pi, 60)
    bend = np.stack([np.sin(turn), np.cos(turn), 0 * turn], axis=1) * 0.01
    arm = np.linspace(0.05, 0.001, 60)
    one = np.stack([-arm, np.full(60, 0.01), 0 * arm], axis=1)
    other = np.stack([-arm[::-1], np.full(60, -0.01), 0 * arm], axis=1)
    xyz = np.concatenate([one, bend, other])
    # The first seed, in the middle of its arm, is nearer in space to the other arm's end.
    owner = split_points(xyz, [np.array([0]), np.array([150])])
    assert (owner[:60] == 0).all()
    assert (owner[120:] == 1).all()


def test_a_loose_piece_goes_with_its_nearest_neighbour():
    xyz = np.concatenate([make_strip(), make_strip() + np.array([0.08, 0.0, 0.0])])
    owner = split_points(xyz, [np.array([0]), np.array([199])])
    assert (owner[200:] == 1).all()


def test_what_has_no_coordinates_goes_with_the_first():
    xyz = make_strip()
    xyz[190] = np.nan
    assert split_points(xyz, [np.array([0]), np.array([199])])[190] == 0


@pytest.mark.parametrize(
    ("seeds", "words"),
    [
        ([[0]], "both sides"),
        ([[0], []], "both sides"),
        ([[0], [0]], "two leaves"),
        ([[0], [7]], "without coordinates"),
    ],
)
def test_wrong_seeds(seeds, words):
    xyz = make_strip()
    xyz[7] = np.inf
    with pytest.raises(WrongUse, match=words):
        split_points(xyz, [np.array(group, int) for group in seeds])
