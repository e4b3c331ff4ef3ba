"""Leaves as connected surfaces: neighbouring beams without a jump in range."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.chunks import CHUNK, run_in_pieces, split_evenly
from app.core.errors import WrongUse
from app.core.neighbours.asked import as_points
from app.core.neighbours.grid import SortedGrid, sort_grid
from app.core.neighbours.steps import ScanGrid, UnusableGrid
from app.core.neighbours.voxel import sort_voxels
from app.core.progress import QUIET, Progress

if TYPE_CHECKING:
    from app.core.kernels.segments import Beams

NECK = 0.006
"""Metres: strips narrower than this tie nothing together. Stalks are 1 to 5 mm, and look wider
by the beam; on simulated branches 5 to 8 mm work alike."""
REACH = NECK / 1.2
"""Metres on either side of a point: there a strip of `NECK` fills `SOLID` of the window."""
FRAMED = 0.8
"""Share of its border with nearer surfaces above which a surface may be background in a gap."""
ALL_NEARER = 0.95
"""The same share without the border against no return. On scenes with truth, background has
1.00, leaves have up to 0.93."""


def segment_leaves(
    xyz: Floats, scanner: AnyArray | None, grid: ScanGrid | None, *, jump: float = 0.01,
    minimum: int = 50, largest: float = 0.5, ghosts: Bools | None = None,
    progress: Progress = QUIET,
) -> AnyArray:  # fmt: skip
    """Label the connected surfaces that are neither too small nor too large for a leaf.

    On a grid, cells that touch belong together when their ranges differ by no more than
    `jump`, or than a surface at 72° would let them. What is then too large for a leaf is cut
    where it is narrower than `NECK`, so that a leaf comes off its branch; background that
    shows through a gap is no leaf. Without a grid or a scanner, points belong together when
    their voxels of side `jump` touch; nothing is cut.

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
        _label_on_grid(xyz, position, grid, usable, jump, largest, raw, progress)
    except UnusableGrid:
        _label_by_voxels(xyz, np.flatnonzero(usable), jump, raw)
    progress.report(0.9, "leaves")
    return _keep_leaves(xyz, raw, minimum, largest)


def _label_on_grid(
    xyz: Floats, scanner: Floats, grid: ScanGrid, usable: Bools, jump: float, largest: float,
    raw: Ints, progress: Progress,
) -> None:  # fmt: skip
    """Join what touches; cut what is too large at its necks; drop what others frame."""
    from app.core.kernels.segments import grow_rims

    index = sort_grid(xyz, scanner, grid, None, np.empty(0))
    beams = _view_beams(index, scanner, usable, jump)
    label = _join(beams, beams.usable, progress.part(0.0, 0.3))
    large = _find_large(index, label, largest)
    thick = _mark_solid(beams._replace(usable=large), progress.part(0.3, 0.6))
    solid = _join(beams, thick, progress.part(0.6, 0.9))
    grow_rims(beams._replace(usable=large), solid, REACH)
    solid[_find_large(index, solid, largest)] = -1
    label[large] = np.where(solid < 0, -1, solid + label.max(initial=-1) + 1)[large]
    _drop_framed(beams, label)
    raw[index.member] = label


def _view_beams(index: SortedGrid, scanner: Floats, usable: Bools, jump: float) -> Beams:
    from app.core.kernels.segments import Beams

    x, y, z = index.x - scanner[0], index.y - scanner[1], index.z - scanner[2]
    grid, steps, member = index.grid, index.steps, index.member
    return Beams(
        np.sqrt(x * x + y * y + z * z), usable[member], grid.row[member], grid.column[member],
        index.start, steps.down, steps.across, steps.seam, jump,
    )  # fmt: skip


def _join(beams: Beams, chosen: Bools, progress: Progress) -> Ints:
    """Number of each chosen point's surface, from 0; -1 for the other points."""
    from app.core.kernels.segments import join_cells, number_surfaces

    parent = np.arange(len(chosen))
    # One thread: the pieces write to one table of parents.
    for first in range(0, len(parent), CHUNK):
        join_cells(beams, chosen, parent, first, min(first + CHUNK, len(parent)))
        progress.report(first / len(parent), "leaves")
    label = np.full(len(parent), -1)
    number_surfaces(parent, chosen, label)
    return label


def _mark_solid(beams: Beams, progress: Progress) -> Bools:
    from app.core.kernels.segments import mark_solid

    solid = np.zeros(len(beams.distance), np.bool_)

    def mark(first: int, last: int) -> None:
        mark_solid(beams, REACH, solid, first, last)

    run_in_pieces(mark, split_evenly(len(solid)), progress, "leaves")
    return solid


def _find_large(index: SortedGrid, label: Ints, largest: float) -> Bools:
    """Points of surfaces whose box is too large for a leaf."""
    from app.core.kernels.segments import measure_boxes

    low = np.full((label.max(initial=-1) + 2, 3), np.inf)
    high = np.full_like(low, -np.inf)
    measure_boxes(index.x, index.y, index.z, label, low, high)
    large: Bools = (label >= 0) & (np.linalg.norm(high - low, axis=1) > largest)[label]
    return large


def _drop_framed(beams: Beams, label: Ints) -> None:
    """Unlabel background that shows through a gap: nearer surfaces, and hardly others, frame it.

    A leaf that others hide for the most part still shows farther surfaces beside it.
    """
    from app.core.kernels.segments import EMPTY, FARTHER, NEARER, count_borders

    border = np.zeros((label.max(initial=-1) + 2, 4), np.int64)
    count_borders(beams, label, border)
    nearer, seen = border[:, NEARER], border[:, NEARER] + border[:, FARTHER]
    framed = (nearer > FRAMED * (seen + border[:, EMPTY])) & (nearer > ALL_NEARER * seen)
    label[(label >= 0) & framed[label]] = -1


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
