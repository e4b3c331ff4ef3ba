"""Tests that a recovered scan grid must pass: doubtful means refused."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.neighbours.steps import EMPTY_CELLS_PER_POINT, UnusableGrid
from app.core.neighbours.waves import NO_LINES

MOST_STRAY = 0.2
"""Upper quartile of how far points lie from their line, in steps; 0.375 by chance."""
MOST_FAR = 0.05
"""Share of points more than 0.35 steps from their row or column; 0.51 by chance."""
FEW_FAR = 0.01
"""The same where the others lie well on their lines: rounding explains none of them."""
SHARP = 0.1
BLOCKS = 64
LEAST_FILLED = 0.38
"""Share of the neighbours of a filled cell that are filled."""
LEAST_EVEN = 0.35
"""Filled cells one line away over those two lines away: 0 where each second line is empty."""
CLOSE = 4.0
"""Points of a cell are of one surface if nearer than this times neighbouring cells' are."""
CLOSE_SHARE = 0.002
"""... and than this share of the range: no scanner tells echoes so near one another apart."""
ROUNDING = 1e-9
MOST_CLOSE = 0.03


def check_empty(rows: int, columns: int, points: int) -> None:
    """Refuse a grid that is nearly empty."""
    if rows * columns > EMPTY_CELLS_PER_POINT * points + 1_000_000:
        raise UnusableGrid("nearly all cells of the grid would be empty")


def check_places(counts: Ints) -> Floats:
    """Refuse points that do not lie on lines; upper quartiles of their distances, in steps."""
    total, far = counts[2, :2]
    if not total:
        raise UnusableGrid(NO_LINES)
    edges = np.linspace(0.0, 0.5, counts.shape[1] + 1)[1:]
    stray = np.array([edges[np.searchsorted(np.cumsum(c), 0.75 * total)] for c in counts[:2]])
    if stray.max() > MOST_STRAY:
        raise UnusableGrid(
            f"{NO_LINES}: a quarter lies {stray.max():.2f} of a step or more beside them"
        )
    if far > (MOST_FAR if stray.max() > SHARP else FEW_FAR) * total:
        raise UnusableGrid(
            f"{100 * far / total:.0f} % of the points lie between the rows and columns of the "
            "others: two scans seem merged, or coordinates are rounded too coarsely"
        )
    return stray


def check_blocks(
    xyz: Floats, scanner: Floats, row: AnyArray, column: AnyArray, last: tuple[int, int]
) -> None:
    """Refuse grids whose blocks are too thin, or hold one surface twice.

    `last` are the last row and column. Two echoes of a beam come from surfaces that lie apart;
    a surface that was scanned twice gives pairs nearly at the same range. Exact duplicates
    are no sign of anything.
    """
    from app.core.kernels.recovered import PATCH, gather_blocks

    slot = _choose_blocks(row, column, (last[0] // PATCH + 1, last[1] // PATCH + 1), PATCH)
    cell, distance = gather_blocks(xyz, scanner, row, column, slot)
    order = np.lexsort((distance, cell))
    cell, distance = cell[order], distance[order]
    first = np.append(True, cell[1:] != cell[:-1])
    nearest = np.full((int(slot.max()) + 1, PATCH, PATCH), np.nan)
    nearest.ravel()[cell[first]] = distance[first]
    _check_filled(np.isfinite(nearest))
    apart = np.abs(np.diff(nearest, axis=2))
    apart = apart[np.isfinite(apart)]
    gap = distance[1:] - distance[:-1]
    limit = np.minimum(CLOSE * float(np.median(apart)), CLOSE_SHARE * distance[1:])
    close = ~first[1:] & (gap > ROUNDING * distance[1:]) & (gap < limit)
    if np.count_nonzero(close) > MOST_CLOSE * len(cell):
        raise UnusableGrid("cells hold one surface several times: two scans seem merged")


def _choose_blocks(row: AnyArray, column: AnyArray, shape: tuple[int, int], size: int) -> AnyArray:
    """Number of each chosen block, or -1; blocks with many points are chosen more often."""
    sample = np.random.default_rng(0).integers(0, len(row), BLOCKS)
    sample = sample[row[sample] >= 0]
    slot = np.full(shape, -1, np.int32)
    slot[row[sample] // size, column[sample] // size] = 0
    places = np.flatnonzero(slot == 0)
    slot.ravel()[places] = np.arange(len(places))
    return slot


def _check_filled(filled: Bools) -> None:
    """Refuse blocks (b, rows, columns) in which few cells beside a filled one are filled."""
    for across in (False, True):
        lines = filled.swapaxes(1, 2) if across else filled
        one, two = (_share_beside(lines, apart) for apart in (1, 2))
        if one < LEAST_EVEN * two:
            raise UnusableGrid("the steps between rows or columns cannot be told for certain")
        if one < LEAST_FILLED:
            raise UnusableGrid("the scan is thinned: most beams beside a point have none")


def _share_beside(lines: Bools, apart: int) -> float:
    own, other = lines[:, apart:], lines[:, :-apart]
    return float((own & other).sum() / max(int(own.sum()), 1))
