"""Where the beams of a scan grid point, learnt from the points themselves.

The noise of a scan lies along the beam, so that directions are as exact as the file. Elevation
is a function of the row plus a small one of the column, azimuth of the column plus one of the
row: real scanners lean, and their columns are not quite upright.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.neighbours.steps import Cells, UnusableGrid
from app.core.normals.rules import REACH

SAMPLES = 8_000
"""Points that directions are learnt from."""
CHECKED = 4000
"""Pairs of neighbouring cells that the steps are tested on."""
ROUNDS = 2
SMOOTH = 4
"""Lines to either side over which a step is averaged."""
STRAY = 0.3
"""Share of a step that neighbouring beams may stray from it (upper quartile)."""
CHANGE = 0.2
"""Share by which a step may change from some lines to the next."""
SEAM = 0.25
"""Share of a step by which the last column may miss its place beside the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """Directions of a scan grid's beams.

    Attributes
    ----------
    down : (rows,) radians
        Elevation from each row to the next.
    turn : (columns,) radians
        Azimuth from each column to the next.
    level : (rows,)
        Cosine of the elevation, which makes the azimuth's step an angle.
    uneven_row, uneven_column : (rows,) and (columns,) bool
        The step changes so near that a window would hold both.
    axes : (3, 3)
        The scanner's axes, as rows; the third is the one that it turns about.
    seam : bool
        The last column lies beside the first.
    """

    down: Floats
    turn: Floats
    level: Floats
    uneven_row: Bools
    uneven_column: Bools
    axes: Floats
    seam: bool


def learn_beams(xyz: Floats, scanner: Floats, cells: Cells, number: AnyArray, lines: Ints) -> Beams:
    """Learn steps and axes.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    cells : Cells
    number : (rows, columns) integers
        Number of the point in each cell, from 1; 0 without one.
    lines : (l,) integers
        Rows that are filled in `number`, and so are the rows after them.

    Raises
    ------
    UnusableGrid
        The grid is too empty, or its cells do not follow the beams from this position.
    """
    sample = sample_points(len(xyz))
    row, column, beams = _known(cells.row[sample], cells.column[sample], xyz[sample] - scanner)
    pairs = [_pair_up(xyz, scanner, number, lines, apart) for apart in ((0, 1), (1, 0))]
    if np.ptp(row) == 0 or np.ptp(column) == 0 or not all(len(pair[0]) for pair in pairs):
        raise UnusableGrid("the grid has no neighbouring cells to measure its steps by")
    # The axes that the rows themselves tell, so that a scan and its copy turned give the same;
    # upright ones where rows are too few or too rough for that.
    for axes in (_find_axes(beams, row, cells.rows), np.eye(3)):
        learnt = _learn(beams @ axes.T, row, column, number.shape, axes)
        stray = max(_measure_stray(learnt, *pair) for pair in pairs)
        if stray <= STRAY:
            return learnt
    raise UnusableGrid(
        "rows and columns do not follow the beams from this position "
        f"(neighbouring beams stray {stray:.1f} steps)"
    )


def sample_points(total: int) -> Ints:
    """Numbers of points all over the scan, in no rhythm with its rows and columns."""
    if total <= 2 * SAMPLES:
        return np.arange(total)
    place = np.arange(SAMPLES)
    jitter = (place * 0.6180339887) % 1.0  # golden ratio: evenly spread, never periodic
    return ((place + jitter) * (total / SAMPLES)).astype(np.int64)


def _known(row: AnyArray, column: AnyArray, beams: Floats) -> tuple[AnyArray, AnyArray, Floats]:
    """Unit beams, and their cells; those without a range left out."""
    with np.errstate(invalid="ignore", over="ignore"):
        size = np.linalg.norm(beams, axis=1)
    fine = np.isfinite(size) & (size > 0.0)
    if not fine.any():
        raise UnusableGrid("no point has a range")
    return row[fine], column[fine], beams[fine] / size[fine, None]


def _directions(xyz: Floats, scanner: Floats, numbers: AnyArray) -> Floats:
    beams: Floats = xyz[numbers - 1] - scanner
    beams /= np.linalg.norm(beams, axis=1)[:, None]
    return beams


def _learn(
    beams: Floats, row: Ints, column: Ints, shape: tuple[int, ...], axes: Floats
) -> Beams:  # fmt: skip
    rows, columns = shape
    height = np.arcsin(np.clip(beams[:, 2], -1.0, 1.0))
    turn = np.arctan2(beams[:, 1], beams[:, 0])
    elevation, _ = _split_lines(height, row, column, rows, columns, False)
    azimuth, _ = _split_lines(turn, column, row, columns, rows, True)
    steps = _steps(elevation), _steps(azimuth)
    around = columns * float(np.mean(steps[1]))
    gap = 2.0 * np.pi - abs(azimuth[-1] - azimuth[0])
    seam = columns >= 12 and abs(gap / abs(around / columns) - 1.0) <= SEAM
    uneven = _find_changes(elevation), _find_changes(azimuth)
    return Beams(*steps, np.cos(elevation), *uneven, axes, bool(seam))


def _find_changes(angles: Floats) -> Bools:
    """Lines so near a change of step that a window would hold both steps."""
    apart = 2 * SMOOTH
    uneven = np.zeros(len(angles), bool)
    if len(angles) <= 2 * apart:
        return uneven
    step = angles[apart:] - angles[:-apart]
    before, after = step[:-apart], step[apart:]
    changes = np.abs(after - before) > CHANGE * np.minimum(np.abs(before), np.abs(after))
    for line in np.flatnonzero(changes) + apart:
        uneven[max(line - REACH, 0) : line + REACH + 1] = True
    return uneven


def _split_lines(
    angle: Floats, line: Ints, across: Ints, lines: int, crossing: int, turns: bool
) -> tuple[Floats, Floats]:
    """Angle of each line, and what the crossing lines add to it; gaps filled evenly."""
    count = np.bincount(line, minlength=lines)
    known = count > 0
    if turns:
        mean = np.arctan2(
            np.bincount(line, np.sin(angle), lines), np.bincount(line, np.cos(angle), lines)
        )
        of_line = _fill_lines(np.unwrap(mean[known]), known)
    else:
        sums = np.bincount(line, angle, lines)
        of_line = _fill_lines(sums[known] / count[known], known)
    added = np.zeros(crossing)
    crossed = np.maximum(np.bincount(across, minlength=crossing), 1)
    rest = angle - of_line[line]
    if turns:
        rest = (rest + np.pi) % (2.0 * np.pi) - np.pi
    for _ in range(ROUNDS):
        change = np.bincount(across, rest, crossing) / crossed
        added += change
        rest -= change[across]
        change = np.bincount(line, rest, lines)[known] / count[known]
        whole = _fill_lines(change, known)
        of_line += whole
        rest -= whole[line]
    return of_line, added


def _fill_lines(angles: Floats, known: AnyArray) -> Floats:
    """Angles of all lines; those without points lie evenly between or beyond their neighbours."""
    lines, places = np.arange(len(known)), np.flatnonzero(known)
    filled = np.interp(lines, places, angles)
    step = (angles[-1] - angles[0]) / max(places[-1] - places[0], 1)
    filled[: places[0]] = angles[0] + step * (lines[: places[0]] - places[0])
    filled[places[-1] :] = angles[-1] + step * (lines[places[-1] :] - places[-1])
    return np.asarray(filled)


def _steps(angles: Floats) -> Floats:
    """Step from line to line, averaged over a few."""
    lines = np.arange(len(angles))
    low, high = np.maximum(lines - SMOOTH, 0), np.minimum(lines + SMOOTH, len(angles) - 1)
    steps: Floats = (angles[high] - angles[low]) / (high - low)
    return np.where(np.abs(steps) > 1e-12, steps, 1e-12)


def _pair_up(
    xyz: Floats, scanner: Floats, number: AnyArray, lines: Ints, apart: tuple[int, int]
) -> tuple[Floats, Floats, Ints, Ints, tuple[int, int]]:
    """Beams on some rows, and the change to those of the next cells, where both are filled."""
    columns = number.shape[1] - apart[1]
    usable = lines[lines + apart[0] < number.shape[0]]
    own = number[usable, :columns]
    other = number[usable + apart[0], apart[1] :]
    line, column = np.nonzero((own > 0) & (other > 0))
    thin = max(1, len(line) // CHECKED)
    line, column = line[::thin], column[::thin]
    beams = _directions(xyz, scanner, own[line, column])
    change = _directions(xyz, scanner, other[line, column]) - beams
    return beams, change, usable[line], column, apart


def _measure_stray(
    learnt: Beams, beams: Floats, change: Floats, row: Ints, column: Ints, apart: tuple[int, int]
) -> float:
    """Upper quartile of what neighbouring beams stray from the step, in the smaller step."""
    own, moved = beams @ learnt.axes.T, change @ learnt.axes.T
    flat = np.maximum(np.hypot(own[:, 0], own[:, 1]), 1e-6)
    side = (own[:, 0] * moved[:, 1] - own[:, 1] * moved[:, 0]) / flat
    rise = (
        flat * moved[:, 2] - own[:, 2] * (own[:, 0] * moved[:, 0] + own[:, 1] * moved[:, 1]) / flat
    )
    down, turn = learnt.down[row], learnt.turn[column] * flat
    away = np.hypot(rise - apart[0] * down, side - apart[1] * turn)
    return float(np.quantile(away / np.minimum(np.abs(down), np.abs(turn)), 0.75))


def _find_axes(beams: Floats, row: Ints, rows: int) -> Floats:
    """Axes whose third is the direction in which the beams of a row differ least."""
    count = np.maximum(np.bincount(row, minlength=rows), 1)
    mean = np.stack([np.bincount(row, b, rows) for b in beams.T], axis=1) / count[:, None]
    apart = beams - mean[row]
    axis = np.linalg.eigh(apart.T @ apart)[1][:, 0]
    axis = axis if axis[2] >= 0 else -axis
    across = np.cross(axis, [0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(axis, across), axis])
