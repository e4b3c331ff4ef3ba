"""Neighbours without a grid: points sorted by voxel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.chunks import count_processors, run_in_pieces, split_evenly

BOXES = 126
PIECE = 200_000
MOST_PARTS = 16


@dataclass(frozen=True, slots=True, eq=False)
class SortedVoxels:
    """Points voxel by voxel.

    Attributes
    ----------
    x, y, z : (m,) metres
    member : (m,) int64
        Number of each point in the scan.
    keys : (v,) int64
        Voxels that hold points, rising.
    start : (v + 1,) int64
        The points of voxel k are start[k] to start[k + 1].
    """

    x: Floats
    y: Floats
    z: Floats
    member: Ints
    keys: Ints
    start: Ints


def crop_to(xyz: Floats, scanner: Floats, points: Ints, margin: float) -> Ints:
    """Numbers of the usable points that lie around the asked ones, rising.

    Leaves far apart are no trouble: only boxes of a coarse lattice that hold an asked point,
    and their neighbours, are kept.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    points : (k,)
        Numbers of the asked points; all must have finite coordinates.
    margin : float
        Metres around the asked points that must be kept at least.
    """
    from app.core.kernels.voxels import mark_boxes, usable_in_boxes

    if not len(points):
        return np.empty(0, np.int64)
    asked = xyz[points]
    low, high = asked.min(axis=0), asked.max(axis=0)
    size = max(margin * 1.001, float((high - low).max()) / BOXES)
    low = low - size
    nx, ny, nz = ((high - low) / size).astype(np.int64) + 2
    marks = np.zeros((2, nx, ny, nz), np.bool_)
    mark_boxes(xyz, points, low, size, marks)
    kept: Ints = usable_in_boxes(xyz, scanner, low, size, marks)
    return kept


def usable_points(xyz: Floats, scanner: Floats) -> Ints:
    """Numbers of the points with a finite range above zero, rising."""
    from app.core.kernels.voxels import find_usable

    usable = np.empty(len(xyz), np.bool_)
    run_in_pieces(
        lambda first, last: find_usable(xyz, scanner, first, last, usable),
        split_evenly(len(xyz), PIECE),
    )
    return np.flatnonzero(usable)


def sort_voxels(xyz: Floats, points: Ints, cell: float) -> SortedVoxels:
    """Sort points (k,) of xyz (n, 3) by voxels of side `cell` metres.

    Parts of the keys, by size, are sorted in threads.
    """
    from app.core.kernels.voxels import take_points, voxel_keys

    size = len(points)
    sample = points[:: max(1, size // 1000)]
    centre = np.median(xyz[sample], axis=0)
    keys = np.empty(size, np.int64)
    run_in_pieces(
        lambda first, last: voxel_keys(xyz, points, centre, cell, first, last, keys),
        split_evenly(size, PIECE),
    )
    parts = min(count_processors(), MOST_PARTS) if size > PIECE else 1
    limits = np.quantile(keys[:: max(1, size // 1000)], np.arange(1, parts) / parts)
    part = np.searchsorted(limits.astype(np.int64), keys).astype(np.uint8)
    begin = np.concatenate([[0], np.cumsum(np.bincount(part, minlength=parts))])
    x, y, z = np.empty(size), np.empty(size), np.empty(size)
    member, rising = np.empty(size, np.int64), np.empty(size, np.int64)

    def sort_part(k: int, _: int) -> None:
        own = np.flatnonzero(part == k)
        order = own[np.argsort(keys[own], kind="stable")]
        take_points(xyz, points, keys, order, begin[k], x, y, z, member, rising)

    run_in_pieces(sort_part, np.arange(parts + 1))
    first = np.flatnonzero(np.diff(rising, prepend=rising[0] - 1))
    return SortedVoxels(x, y, z, member, rising[first], np.append(first, size))
