"""Cuts and merges of segments."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import WrongUse
from app.core.segment_edits import merge_segments, split_segment


def make_strip():
    x, y = (a.ravel() for a in np.mgrid[:40, :5])
    return np.stack([x, y, 0 * x], axis=1) * 0.001


def test_seeds_cut_in_the_middle_between_them():
    xyz = make_strip()
    labels = np.full(len(xyz), 3)
    split = split_segment(labels, xyz, [np.array([2]), np.array([len(xyz) - 3])])
    assert (labels == 3).all()
    assert set(split[xyz[:, 0] < 0.019]) == {3}
    assert set(split[xyz[:, 0] > 0.021]) == {4}


def test_merge_is_the_way_back():
    xyz = make_strip()
    labels = np.full(len(xyz), 0)
    split = split_segment(labels, xyz, [np.array([0]), np.array([199])])
    assert np.array_equal(merge_segments(split, [[0, 1]]), labels)


def test_what_has_no_coordinates_stays():
    xyz = make_strip()
    xyz[100] = np.nan
    split = split_segment(np.zeros(len(xyz), int), xyz, [np.array([0]), np.array([199])])
    assert split[100] == 0


@pytest.mark.parametrize(
    ("seeds", "words"),
    [
        ([[0]], "on each side"),
        ([[0], []], "on each side"),
        ([[0], [0]], "two leaves"),
        ([[0], [199]], "on one leaf"),
    ],
)
def test_wrong_seeds(seeds, words):
    xyz = make_strip()
    labels = np.where(np.arange(200) < 150, 0, -1)
    with pytest.raises(WrongUse, match=words):
        split_segment(labels, xyz, [np.array(group, int) for group in seeds])


@pytest.mark.parametrize("groups", [[[0, 7]], [[-1, 0]], [[0, 1], [1, 2]]])
def test_wrong_merges(groups):
    with pytest.raises(WrongUse):
        merge_segments(np.array([0, 1, 2, -1]), groups)
