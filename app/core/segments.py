"""Leaves as connected surfaces: neighbouring beams without a jump in range."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.background import find_scraps
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
SIGMAS, LEAST_JUMP, LARGEST_JUMP = 4.0, 0.003, 0.01
"""Ranges of neighbours on one surface differ by so many σ of the noise; metres."""
ROUND, LONG, THICK = 0.25, 3.0, 0.0018
"""A stem is round (third over second spread of its points, so many metres at least) and long
(first over second)."""
SLENDER = 10.0
"""Of a stem too is what is so long; leaves of scenes with truth reach 8."""
CLUMP, DEEP = 0.2, 0.005
"""A clump is deep: third over first spread, and metres."""
ROUGH = 0.002
"""Metres: and it lies so far off a surface of second degree, as a rolled leaf does not."""
DOUBTFUL = 0.06
"""Metres: a longer surface is cut at its necks too, if that leaves two parts or more."""
PART, FEWEST = 0.1, 30
"""Share of the surface, and points, that such a part has at least."""
FRAMED = 0.8
"""Share of its border with nearer surfaces above which a surface may be background in a gap."""
SMALLEST = 5e-5
"""Square metres across the beam. On simulated scans nothing smaller is a leaf of 50 full hits."""
ALL_NEARER = 0.95
"""The same share without the border against no return. On scenes with truth, background has
1.00, leaves have up to 0.93."""


def segment_leaves(
    xyz: Floats, scanner: AnyArray | None, grid: ScanGrid | None, *, jump: float | None = None,
    minimum: int = 50, largest: float = 0.5, ghosts: Bools | None = None,
    progress: Progress = QUIET,
) -> AnyArray:  # fmt: skip
    """Label the connected surfaces that are neither too small nor too large for a leaf.

    On a grid, cells that touch belong together when their ranges differ by no more than
    `jump`, or than a surface at 72° would let them. What is then too large for a leaf is cut
    where it is narrower than `NECK`, so that a leaf comes off its branch; background that
    shows through a gap, or lies in the plane of a wall, is no leaf. Without a grid or a
    scanner, points belong together when their voxels of side `jump` touch; nothing is cut.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres or None
    grid : ScanGrid or None
    jump : float or None
        Metres; None takes four times the noise of a range, from 3 to 10 mm, and 10 mm for voxels.
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
    if jump is not None and not jump > 0.0:
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
        _label_on_grid(xyz, position, grid, usable, jump, minimum, largest, raw, progress)
    except UnusableGrid:
        _label_by_voxels(xyz, np.flatnonzero(usable), jump or LARGEST_JUMP, raw)
    progress.report(0.9, "leaves")
    return _keep_leaves(xyz, raw, minimum, largest)


def _label_on_grid(
    xyz: Floats, scanner: Floats, grid: ScanGrid, usable: Bools, jump: float | None, minimum: int,
    largest: float, raw: Ints, progress: Progress,
) -> None:  # fmt: skip
    """Join what touches; cut the too large at necks; part what crosses; drop what is framed."""
    from app.core.kernels.segments import grow_rims

    index = sort_grid(xyz, scanner, grid, None, np.empty(0))
    if jump is None:
        jump = float(np.clip(SIGMAS * index.steps.noise, LEAST_JUMP, LARGEST_JUMP))
    beams = _view_beams(index, scanner, usable, jump)
    label = _join(beams, beams.usable, progress.part(0.0, 0.2))
    too_large = _find_large(index, label, largest)
    large = too_large | _find_large(index, label, min(largest, DOUBTFUL))
    thick = _mark_solid(beams._replace(usable=large), progress.part(0.2, 0.4))
    solid = _join(beams, thick, progress.part(0.4, 0.6))
    grow_rims(beams._replace(usable=large), solid, REACH)
    large &= too_large | _find_split(label, solid)
    walls = np.where(too_large, label, -1)
    solid[_find_large(index, solid, largest)] = -1
    label[large] = np.where(solid < 0, -1, solid + label.max(initial=-1) + 1)[large]
    _part_crossing(index, scanner, label, minimum, largest, progress.part(0.6, 0.85))
    _rejoin(index, scanner, beams, label, largest)
    _drop_framed(beams, label)
    _drop_background(index, walls, label)
    _drop_tiny(beams, label)
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


def _part_crossing(
    index: SortedGrid, scanner: Floats, label: Ints, minimum: int, largest: float,
    progress: Progress,
) -> None:  # fmt: skip
    """Give leaves that cross labels of their own; surfaces too large for a leaf stay."""
    from app.core.touching import part_touching

    chosen = np.ones(label.max(initial=-1) + 1, np.bool_)
    chosen[label[_find_large(index, label, largest)]] = False
    beams = np.stack([index.x, index.y, index.z], axis=1) - scanner
    row, column = index.grid.row[index.member], index.grid.column[index.member]
    total = index.grid.columns if index.steps.seam else None
    part_touching(beams, row, column, label, chosen, index.steps.noise, minimum, total, progress)


def _rejoin(index: SortedGrid, scanner: Floats, beams: Beams, label: Ints, largest: float) -> None:
    """Join pieces of one surface that ghosts or a stalk cut, up to the size of a leaf."""
    from app.core.kernels.segments import list_meetings
    from app.core.rejoining import rejoin_pieces

    before = label.copy()
    meeting = np.empty((len(label), 2), np.int64)
    meeting = meeting[: list_meetings(beams, label, meeting)]
    places = np.stack([index.x, index.y, index.z], axis=1) - scanner
    row, column = index.grid.row[index.member], index.grid.column[index.member].astype(np.int64)
    rejoin_pieces(places, row, column, label, meeting, index.steps.noise)
    large = _find_large(index, label, largest)
    label[large] = before[large]


def _find_split(label: Ints, solid: Ints) -> Bools:
    """Points of surfaces that hold two solid parts or more, each a fair share of the whole."""
    both = (label >= 0) & (solid >= 0)
    parts = np.zeros(label.max(initial=-1) + 2, np.int64)
    if both.any():
        part_size = np.bincount(solid[both])
        whole = np.zeros(len(part_size), np.int64)
        whole[solid[both]] = label[both]
        size = np.bincount(label[label >= 0])
        fair = (part_size > 0) & (part_size >= PART * size[whole]) & (part_size >= FEWEST)
        np.add.at(parts, whole[fair], 1)
    split: Bools = (label >= 0) & (parts >= 2)[label]
    return split


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


def _drop_background(index: SortedGrid, walls: Ints, label: Ints) -> None:
    """Unlabel what lies in the plane of a wall; `walls` tells the surfaces before they were cut."""
    xyz = np.stack([index.x, index.y, index.z], axis=1)
    first = int(label.max(initial=-1)) + 1
    # A leaf that was cut off its wall is told by its leaf's label.
    both = np.where(label >= 0, label, np.where(walls >= 0, walls + first, -1))
    scrap = find_scraps(xyz, both, both >= first, index.steps.noise)
    label[(label >= 0) & scrap[label]] = -1


def _drop_tiny(beams: Beams, label: Ints) -> None:
    """Unlabel what is smaller than `SMALLEST` across the beam: bits of stalks and folds."""
    known = label >= 0
    cell = beams.distance**2 * beams.down[beams.column] * beams.across[beams.row]
    area = np.bincount(label[known], cell[known], minlength=int(label.max(initial=-1)) + 1)
    label[known] = np.where(area[label[known]] < SMALLEST, -1, label[known])


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
    leaf &= ~_find_wood(sorted_xyz, begin, count)
    number = np.full(len(count), -1, np.int32)
    chosen = np.flatnonzero(leaf)
    number[chosen[np.argsort(first[chosen])]] = np.arange(len(chosen))
    labels[member] = number[component]
    return labels


def _find_wood(points: Floats, begin: Ints, count: Ints) -> Bools:
    """Groups of points that are long and round as stems are, or deep as clumps are, (g,)."""
    mean = np.add.reduceat(points, begin, axis=0) / count[:, None]
    off = points - np.repeat(mean, count, axis=0)
    square = np.add.reduceat(off[:, :, None] * off[:, None, :], begin, axis=0)
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(square / count[:, None, None]), 0.0))
    third, second, first = spread.T
    stem = (third > ROUND * second) & (first > LONG * second) & (third > THICK)
    stem |= first > SLENDER * second
    clump = (third > CLUMP * first) & (third > DEEP)
    for k in np.flatnonzero(clump & ~stem):
        clump[k] = _measure_roughness(off[begin[k] : begin[k] + count[k]]) > ROUGH
    wood: Bools = stem | clump
    return wood


def _measure_roughness(off: Floats) -> float:
    """Root mean square off a surface of second degree over the plane of points about their mean."""
    axes = np.linalg.svd(off.T @ off)[0]
    a, b, height = (off @ axes).T
    size = float(np.abs(a).max()) or 1.0
    a, b = a / size, b / size
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
    found = np.linalg.lstsq(terms.T @ terms, terms.T @ height, rcond=1e-9)[0]
    return float(np.sqrt(np.mean((height - terms @ found) ** 2)))
