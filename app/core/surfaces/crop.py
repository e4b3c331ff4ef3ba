"""A leaf and what lies around it, as cells of the scan grid.

The noise of a scan lies along its beams, so that the directions of cells are as exact as the
file. They are learnt from all points of the crop, and hold for cells without a point too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints, finite_rows
from app.core.errors import BadInput
from app.core.holder import across_of
from app.core.neighbours.steps import Cells, UnusableGrid, check_shape

EMPTY, MEMBER, GHOST, NEARER, FARTHER, OUTSIDE = 0, 1, 2, 3, 4, 5
"""What a cell holds: no return, the leaf, a point between surfaces, something in front of the
leaf or behind it; or it lies beyond the scan."""
MARGIN = 12
"""Cells around a leaf that are looked at too."""
STRAY = 0.3
"""Share of a step by which points may lie beside the directions of their cells."""
LEARNT = 4000
"""Points at most that directions are learnt from."""
ALIKE = 1e-12
"""Radians: a smaller step between beams is rounding."""
SWERVE = 0.05
"""Share of the leaf's range by which a mixed range may differ, where it scaled the light."""
FEWEST = 8
"""Points below which a leaf has no surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The points of a scan by cell: `number` is (rows, columns), -1 where there is no return.

    Of several points in a cell the nearest one is told. `echo`, (n,), is the power received from
    each point in any unit, where it is known; `scaled`: it was made from a reflectance with the
    point's range. Instruments differ in what range they take for a beam on two surfaces, so
    that such an echo tells nothing where that range is far from both.
    """

    xyz: Floats
    scanner: Floats
    cells: Cells
    number: Ints
    distance: Floats
    seam: bool
    echo: Floats | None = None
    scaled: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Crop:
    """Cells around a leaf, (h, w) arrays.

    Attributes
    ----------
    state : int8
        `EMPTY`, `MEMBER`, `GHOST`, `NEARER`, `FARTHER` or `OUTSIDE`.
    point : int64
        Number of the member in the cell, or -1.
    side, up : tangents
        Direction of each cell about the beam to the leaf's middle.
    inverse : 1 / metres
        One over the depth of members along that beam; NaN elsewhere.
    ranges : metres
        Range of what is in the cell; NaN without a return.
    light : or None
        Power received, any unit; 0 without a return, NaN where unknown.
    axes : (3, 3)
        Ahead, to the side, up; rows.
    scanner : (3,) metres
    pitch : (2,) metres
        From row to row and from column to column, across the beam at the leaf's range.
    distance : float
        Metres: median range of the leaf.
    """

    state: AnyArray
    point: Ints
    side: Floats
    up: Floats
    inverse: Floats
    ranges: Floats
    light: Floats | None
    axes: Floats
    scanner: Floats
    pitch: tuple[float, float]
    distance: float

    @property
    def members(self) -> Bools:
        """Cells of the leaf."""
        found: Bools = self.state == MEMBER
        return found


def lay_out(
    xyz: Floats, scanner: AnyArray, cells: Cells, seam: bool = False, echo: Floats | None = None,
    scaled: bool = False,
) -> Layout:  # fmt: skip
    """Put the points of a scan into their cells, once for all its leaves.

    Raises
    ------
    BadInput, UnusableGrid
        The grid belongs to other points, or is nearly empty.
    """
    check_shape(xyz, cells)
    row, column = cells.row.astype(np.int64), cells.column.astype(np.int64)
    outside = (row < 0) | (row >= cells.rows) | (column < 0) | (column >= cells.columns)
    if outside.any():
        raise BadInput(
            f"A point lies outside the grid of {cells.rows} × {cells.columns} cells.",
            "The file's rows or columns are damaged.",
        )
    away = np.asarray(scanner, np.float64)
    distance = np.full(len(xyz), np.nan)
    known = np.flatnonzero(finite_rows(xyz))
    distance[known] = np.linalg.norm(xyz[known] - away, axis=1)
    distance[distance == 0.0] = np.nan  # at the scanner itself nothing has a direction
    known = known[distance[known] > 0.0]
    known = known[np.argsort(-distance[known], kind="stable")]  # the nearest comes last
    number = np.full((cells.rows, cells.columns), -1)
    number[row[known], column[known]] = known
    return Layout(xyz, away, cells, number, distance, seam, echo, scaled)


def crop_leaf(layout: Layout, members: Ints, ghosts: Bools | None = None) -> Crop:
    """Cut a leaf out of its scan.

    Parameters
    ----------
    layout : Layout
    members : (k,)
        Numbers of the leaf's points.
    ghosts : (n,) bool or None
        Points of the scan that lie between surfaces; they belong to none.

    Raises
    ------
    BadInput
        Too few points with a range, or none beside another.
    UnusableGrid
        The cells do not follow the beams from this position.
    """
    members = members[np.isfinite(layout.distance[members])]
    if len(members) < FEWEST:
        raise BadInput(
            f"A leaf of {len(members)} points with a range has no surface.",
            f"Select {FEWEST} points or more.",
        )
    rows, columns = _frame(layout, members)
    number = _look_up(layout, rows, columns)
    own = np.full(number.shape, -1)
    places = _places(layout, members, rows, columns)
    own[places] = members
    state = _tell_states(layout, number, own, ghosts)
    axes, side, up = _learn_directions(layout, np.where(own >= 0, own, number), members)
    inverse = np.full(number.shape, np.nan)
    inside = own >= 0
    inverse[inside] = 1.0 / ((layout.xyz[own[inside]] - layout.scanner) @ axes[0])
    ranges = np.where(number >= 0, layout.distance[number], np.nan)
    ranges[inside] = layout.distance[own[inside]]
    light = None
    if layout.echo is not None:
        light = _light_of(layout.echo, np.where(inside, own, number), state)
    distance = float(np.median(layout.distance[members]))
    if light is not None and layout.scaled:
        light[(state == GHOST) & (np.abs(ranges - distance) > SWERVE * distance)] = np.nan
    pitch = (_pitch(side, up, 0) * distance, _pitch(side, up, 1) * distance)
    return Crop(state, own, side, up, inverse, ranges, light, axes, layout.scanner, pitch, distance)


def _frame(layout: Layout, members: Ints) -> tuple[Ints, Ints]:
    """Rows and columns of the crop; columns go on over the seam, in order."""
    row = layout.cells.row[members].astype(np.int64)
    column = layout.cells.column[members].astype(np.int64)
    total = layout.cells.columns
    if layout.seam:
        # From behind the widest gap on, a leaf on the seam is in one piece.
        filled = np.unique(column)
        gaps = np.diff(np.append(filled, filled[0] + total))
        column = (column - filled[(gaps.argmax() + 1) % len(filled)]) % total
        first = int(filled[(gaps.argmax() + 1) % len(filled)])
    else:
        first = 0
    rows = np.arange(row.min() - MARGIN, row.max() + MARGIN + 1)
    columns = first + np.arange(column.min() - MARGIN, column.max() + MARGIN + 1)
    return rows, columns[:total] if layout.seam else columns


def _look_up(layout: Layout, rows: Ints, columns: Ints) -> Ints:
    """Points of the cells; -1 without one, -2 beyond the scan."""
    total = layout.cells.columns
    inside = (rows >= 0) & (rows < layout.cells.rows)
    wide = np.ones(len(columns), np.bool_) if layout.seam else (columns >= 0) & (columns < total)
    found = np.full((len(rows), len(columns)), -2)
    found[np.ix_(inside, wide)] = layout.number[np.ix_(rows[inside], columns[wide] % total)]
    return found


def _places(layout: Layout, members: Ints, rows: Ints, columns: Ints) -> tuple[Ints, Ints]:
    row = layout.cells.row[members].astype(np.int64) - rows[0]
    column = layout.cells.column[members].astype(np.int64) - columns[0]
    return row, column % layout.cells.columns if layout.seam else column


def _tell_states(layout: Layout, number: Ints, own: Ints, ghosts: Bools | None) -> AnyArray:
    """State of each cell; others are compared with the nearest member's range."""
    from scipy.ndimage import distance_transform_edt

    member = own >= 0
    state = np.full(number.shape, EMPTY, np.int8)
    state[number == -2] = OUTSIDE
    other = (number >= 0) & ~member
    nearest = distance_transform_edt(~member, return_distances=False, return_indices=True)
    leaf = layout.distance[own[nearest[0], nearest[1]]]
    nearer = layout.distance[number] < leaf
    state[other] = np.where(nearer, NEARER, FARTHER)[other]
    if ghosts is not None:
        state[other & ghosts[number]] = GHOST
    state[member] = MEMBER
    return state


def _learn_directions(layout: Layout, number: Ints, members: Ints) -> tuple[Floats, Floats, Floats]:
    """Axes of the crop, and the tangents of its cells: a second degree in row and column."""
    beams = layout.xyz[members] - layout.scanner
    ahead = (beams / np.linalg.norm(beams, axis=1)[:, None]).mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    axes = np.vstack([ahead, *across_of(ahead)])
    place = np.argwhere(number >= 0)
    place = place[:: max(1, len(place) // LEARNT)]
    seen = (layout.xyz[number[place[:, 0], place[:, 1]]] - layout.scanner) @ axes.T
    place, seen = place[seen[:, 0] > 0.0], seen[seen[:, 0] > 0.0]
    shape = np.array(number.shape)
    known = _terms(place, shape)
    wanted = seen[:, 1:] / seen[:, :1]
    found, _, rank, _ = np.linalg.lstsq(known.T @ known, known.T @ wanted, rcond=1e-12)
    if rank < known.shape[1]:
        raise BadInput(
            "The points of the leaf lie in one row or column of the scan: they have no surface.",
            "Select an area, not a row of points.",
        )
    every = np.argwhere(np.ones(number.shape, np.bool_))
    side, up = (_terms(every, shape) @ found).T.reshape(2, *number.shape)
    step = min(_pitch(side, up, 0), _pitch(side, up, 1))
    if not step > ALIKE:
        raise BadInput(
            "The beams to the leaf point all the same way: it has no surface.",
            "The file's coordinates or the scanner's position may be wrong.",
        )
    off = np.hypot(*(known @ found - wanted).T)
    if np.quantile(off, 0.75) > STRAY * step:
        raise UnusableGrid("rows and columns do not follow the beams from this position")
    return axes, side, up


def _terms(place: AnyArray, shape: AnyArray) -> Floats:
    i, j = ((place - 0.5 * shape) / shape.max()).T
    return np.stack([np.ones_like(i), i, j, i * i, i * j, j * j], axis=1)


def _pitch(side: Floats, up: Floats, axis: int) -> float:
    return float(np.median(np.hypot(np.diff(side, axis=axis), np.diff(up, axis=axis))))


def _light_of(echo: Floats, number: AnyArray, state: AnyArray) -> Floats:
    """Light of the cells, (h, w): that of their points, 0 without a return, NaN beyond."""
    light = np.where(number >= 0, echo[number], np.nan)
    light[(number < 0) & (state == EMPTY)] = 0.0
    return light
