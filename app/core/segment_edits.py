"""A leaf cut by hand: seeds say which of its points lie on leaves of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.core.arrays import Floats, Ints, finite_rows
from app.core.errors import WrongUse
from app.core.touching import is_whole, lay_sheet, share_points, unroll

NEIGHBOURS = 8
FEWEST = 30
"""Points of a part below which its shape says nothing."""


def split_points(xyz: Floats, seeds: Sequence[Ints]) -> Ints:
    """Share the points of a leaf out among groups of seeds.

    A point goes with the seeds that are nearest to it along the surface; a piece that hangs
    together with none of them goes with its nearest neighbour in space.

    Parameters
    ----------
    xyz : (n, 3) metres
        Points of the leaf; those without coordinates go with the first group.
    seeds : sequence of (k,) numbers of points
        One group for each leaf that is to be.

    Returns
    -------
    (n,) int64
        Number of each point's group, from 0.

    Raises
    ------
    WrongUse
        Fewer than two groups, an empty one, a point in two groups, or one without coordinates.
    """
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    known = finite_rows(xyz)
    _check_seeds(known, seeds)
    points = np.flatnonzero(known)
    graph = _join_neighbours(xyz[points])
    away = np.full((len(seeds), len(points)), np.inf)
    for k, group in enumerate(seeds):
        sources = np.searchsorted(points, group)
        away[k] = dijkstra(graph, directed=False, indices=sources, min_only=True)
    owner = away.argmin(axis=0)
    reached = np.isfinite(away).any(axis=0)
    if not reached.all():
        near = cKDTree(xyz[points[reached]]).query(xyz[points[~reached]])[1]
        owner[~reached] = owner[reached][near]
    found = np.zeros(len(xyz), np.int64)
    found[points] = owner
    return found


def settle_split(
    beams: Floats, row: Ints, column: Ints, turn: int | None, owner: Ints, seeds: Sequence[Ints]
) -> Ints:
    """Move the cut to where the shapes of the parts say: half way between seeds is a guess only.

    Parameters
    ----------
    beams : (n, 3) metres
        Points of the leaf about the scanner.
    row, column : (n,)
    turn : int or None
        Columns of a full turn, where the grid closes.
    owner : (n,)
        See `split_points`.
    seeds : sequence of (k,) numbers of points

    Returns
    -------
    (n,) int64
        As it was where shapes would take a seed from its group, or leave a part in pieces: waves
        of one leaf are no leaves.
    """
    known = np.flatnonzero(finite_rows(beams))
    parts = [np.flatnonzero(owner[known] == k) for k in range(len(seeds))]
    if min(map(len, parts)) < FEWEST:
        return owner
    sheet = lay_sheet(beams[known], row[known], unroll(column[known].astype(np.int64), turn))
    settled = owner.copy()
    found: list[int] = []
    for part in share_points(sheet, parts, FEWEST):
        inside = [np.isin(group, known[part]) for group in seeds]
        held = [k for k, mine in enumerate(inside) if mine.any()]
        if len(held) != 1 or not inside[held[0]].all():
            return owner
        if not is_whole(sheet, np.isin(np.arange(len(known)), part)):
            return owner
        settled[known[part]] = held[0]
        found += held
    return settled if len(found) == len(seeds) else owner


def _check_seeds(known: Any, seeds: Sequence[Ints]) -> None:
    if len(seeds) < 2 or any(len(group) == 0 for group in seeds):
        raise WrongUse(
            "A leaf is split by seeds on both sides.", "Give a point on each leaf it is to become."
        )
    every = np.concatenate([np.asarray(group, np.int64) for group in seeds])
    if len(np.unique(every)) < len(every):
        raise WrongUse("A point cannot be a seed of two leaves.")
    if not known[every].all():
        raise WrongUse("A point without coordinates cannot be a seed.")


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
