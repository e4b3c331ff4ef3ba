"""Segments put right by hand: seeds that must be leaves of their own, cuts, and merges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.errors import WrongUse

NEIGHBOURS = 8


def merge_segments(labels: AnyArray, groups: Sequence[Sequence[int]]) -> AnyArray:
    """Give all segments of each group the number of its first one; a copy.

    Raises
    ------
    WrongUse
        There is no such segment, or it stands in two groups.
    """
    merged = labels.copy()
    taken: set[int] = set()
    for group in groups:
        for number in group:
            if number < 0 or not (labels == number).any():
                raise WrongUse(f"There is no leaf {number} to merge.")
            if number in taken:
                raise WrongUse(f"Leaf {number} cannot be merged twice.")
            taken.add(number)
            merged[labels == number] = group[0]
    return merged


def split_segment(labels: AnyArray, xyz: Floats, seeds: Sequence[Ints]) -> AnyArray:
    """Cut one segment so that each group of seeds is a leaf of its own; a copy.

    A point goes with the seeds that are nearest to it along the surface. The first group keeps
    the segment's number, the others get new ones.

    Parameters
    ----------
    labels : (n,) integers, -1 for points of no leaf
    xyz : (n, 3) metres
    seeds : sequence of point numbers
        One group for each leaf; all of them lie on one segment.

    Raises
    ------
    WrongUse
        Fewer than two groups, an empty one, points of several leaves or of none, or a point in
        two groups.
    """
    from scipy.sparse.csgraph import dijkstra

    label = _check_seeds(labels, seeds)
    points = np.flatnonzero((labels == label) & np.isfinite(xyz).all(axis=1))
    graph = _join_neighbours(xyz[points])
    away = np.full((len(seeds), len(points)), np.inf)
    for k, group in enumerate(seeds):
        sources = np.searchsorted(points, group)
        away[k] = dijkstra(graph, directed=False, indices=sources, min_only=True)
    owner = away.argmin(axis=0)
    reached = np.isfinite(away).any(axis=0)
    numbers = np.array([label, *(labels.max() + 1 + np.arange(len(seeds) - 1))])
    split = labels.copy()
    split[points] = np.where(reached, numbers[owner], label)
    return split


def _check_seeds(labels: AnyArray, seeds: Sequence[Ints]) -> int:
    if len(seeds) < 2 or any(len(group) == 0 for group in seeds):
        raise WrongUse("A cut needs a point on each side.", "Give two groups of points or more.")
    every = np.concatenate([np.asarray(group, np.int64) for group in seeds])
    if len(np.unique(every)) < len(every):
        raise WrongUse("A point cannot be a seed of two leaves.")
    found = np.unique(labels[every])
    if len(found) != 1 or found[0] < 0:
        raise WrongUse("The seeds of a cut must lie on one leaf.", "Merge leaves first.")
    return int(found[0])


def _join_neighbours(xyz: Floats) -> Any:
    """Distances to the nearest points, as a sparse graph."""
    from scipy.sparse import csr_array
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS + 1, len(xyz))
    far, near = (np.asarray(a).reshape(len(xyz), count) for a in cKDTree(xyz).query(xyz, count))
    rows = np.repeat(np.arange(len(xyz)), count)
    # Points at one place are neighbours too, and a sparse 0 would be no link.
    return csr_array(
        (np.maximum(far.ravel(), 1e-12), (rows, near.ravel())), shape=(len(xyz), len(xyz))
    )
