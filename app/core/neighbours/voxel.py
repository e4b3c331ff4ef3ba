"""Neighbours without a grid: points sorted by voxel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints

BOXES = 126


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


def sort_voxels(xyz: Floats, points: Ints, cell: float) -> SortedVoxels:
    """Sort points (k,) of xyz (n, 3) by voxels of side `cell` metres."""
    from app.core.kernels.voxels import voxel_keys

    centre = np.median(xyz[points[:: max(1, len(points) // 1000)]], axis=0)
    keys = voxel_keys(xyz, points, centre, cell)
    order = np.argsort(keys, kind="stable")
    keys, member = keys[order], points[order]
    first = np.flatnonzero(np.diff(keys, prepend=keys[0] - 1))
    x, y, z = np.ascontiguousarray(xyz[member].T)
    return SortedVoxels(x, y, z, member, keys[first], np.append(first, len(keys)))
