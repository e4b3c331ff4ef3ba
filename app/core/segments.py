"""Leaves as connected surfaces: neighbouring beams without a jump in range."""

from __future__ import annotations

from itertools import product

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.chunks import CHUNK
from app.core.errors import WrongUse
from app.core.neighbours.asked import as_points
from app.core.neighbours.grid import sort_grid
from app.core.neighbours.steps import ScanGrid, UnusableGrid
from app.core.neighbours.voxel import sort_voxels
from app.core.progress import QUIET, Progress


def segment_leaves(
    xyz: Floats, scanner: AnyArray | None, grid: ScanGrid | None, *, jump: float = 0.01,
    minimum: int = 50, largest: float = 0.5, ghosts: Bools | None = None,
    progress: Progress = QUIET,
) -> AnyArray:  # fmt: skip
    """Label the connected surfaces that are neither too small nor too large for a leaf.

    On a grid, cells that touch belong together when their ranges differ by no more than
    `jump`, or than a surface at 72° would let them. Without a grid or a scanner, points
    belong together when their voxels of side `jump` touch.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres or None
    grid : ScanGrid or None
    jump : float
        Metres.
    minimum : int
        Points that a leaf has at least.
    largest : float
        Metres: longest diagonal of a leaf's box along the axes; walls and stems exceed it.
    ghosts : (n,) bool or None
        Points that connect nothing and belong to no leaf.
    progress : Progress

    Returns
    -------
    (n,) int32
        0, 1, … in the order of each leaf's first point; -1 for points of no leaf.

    Raises
    ------
    WrongUse
        `jump` is not positive.
    BadInput, Cancelled
    """
    if not jump > 0.0:
        raise WrongUse(f"The jump between leaves must be positive, not {jump} m.")
    xyz = as_points(xyz)
    usable = finite_rows(xyz)
    if ghosts is not None:
        usable &= ~ghosts
    progress.report(0.0, "leaves")
    raw = np.full(len(xyz), -1, np.int64)
    try:
        if grid is None or scanner is None:
            raise UnusableGrid("the scan has no rows and columns, or no scanner")
        position = np.array(scanner, dtype=np.float64)
        _label_on_grid(xyz, position, grid, usable, jump, raw, progress)
    except UnusableGrid:
        _label_by_voxels(xyz, np.flatnonzero(usable), jump, raw)
    progress.report(0.9, "leaves")
    return _keep_leaves(xyz, raw, minimum, largest)


def _label_on_grid(
    xyz: Floats, scanner: Floats, grid: ScanGrid, usable: Bools, jump: float, raw: Ints,
    progress: Progress,
) -> None:  # fmt: skip
    from app.core.kernels.segments import flatten_roots, join_cells

    index = sort_grid(xyz, scanner, grid, None, np.empty(0))
    kept = usable[index.member]
    beams = np.stack([index.x, index.y, index.z], axis=1) - scanner
    distance = np.linalg.norm(beams, axis=1)
    parent = np.arange(len(index.member))
    # One thread: the pieces write to one table of parents.
    for first in range(0, len(parent), CHUNK):
        join_cells(
            distance, kept, index.start, index.grid.row, index.grid.column, index.member, parent,
            first, min(first + CHUNK, len(parent)),
            index.steps.down, index.steps.across, index.steps.seam, jump,
        )  # fmt: skip
        progress.report(0.9 * first / len(parent), "leaves")
    flatten_roots(parent)
    raw[index.member[kept]] = parent[kept]


def _label_by_voxels(xyz: Floats, points: Ints, jump: float, raw: Ints) -> None:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    from app.core.kernels.voxels import BITS

    if not len(points):
        return
    index = sort_voxels(xyz, points, jump)
    keys = index.keys
    ones, others = [], []
    for dx, dy, dz in product((-1, 0, 1), repeat=3):
        offset = (dx << 2 * BITS) + (dy << BITS) + dz
        if offset > 0:
            place = np.minimum(np.searchsorted(keys, keys + offset), len(keys) - 1)
            touching = np.flatnonzero(keys[place] == keys + offset)
            ones.append(touching)
            others.append(place[touching])
    a, b = np.concatenate(ones), np.concatenate(others)
    links = coo_array((np.ones(len(a), np.bool_), (a, b)), shape=(len(keys), len(keys)))
    _, component = connected_components(links, directed=False)
    raw[index.member] = np.repeat(component, np.diff(index.start))


def _keep_leaves(xyz: Floats, raw: Ints, minimum: int, largest: float) -> AnyArray:
    """Number the components of a leaf's size, in the order of their first points."""
    labels = np.full(len(raw), -1, np.int32)
    member = np.flatnonzero(raw >= 0)
    if not len(member):
        return labels
    _, first, component, count = np.unique(
        raw[member], return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(component, kind="stable")
    begin = np.concatenate([[0], np.cumsum(count)[:-1]])
    sorted_xyz = xyz[member[order]]
    low = np.minimum.reduceat(sorted_xyz, begin, axis=0)
    high = np.maximum.reduceat(sorted_xyz, begin, axis=0)
    leaf = (count >= minimum) & (np.linalg.norm(high - low, axis=1) <= largest)
    number = np.full(len(count), -1, np.int32)
    chosen = np.flatnonzero(leaf)
    number[chosen[np.argsort(first[chosen])]] = np.arange(len(chosen))
    labels[member] = number[component]
    return labels
