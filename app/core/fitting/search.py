"""The best shape of each group, sought over all of its bounds: nobody has to guess a start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.fitting.projection import Projection
from app.core.fitting.roots import CLOSE, find_roots

CANDIDATES = 4
# Share by which sums of squares may differ from rounding alone.
EQUAL = 1e-13
# Numbers of a table of columns that stay in the processor's cache.
TABLE = 200_000
# Share of the shape by which condensed pairs may misplace a minimum at first.
MISPLACED = 1e-3
NUDGE = 1e-4
# Pairs up to which the compiled search is not worth loading.
FEW = 128
SECANTS = 8
SETTLED = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Minima:
    """Candidates for the best shape.

    Attributes
    ----------
    row : (c,) array
        Group; each has at least one candidate.
    shape, rss : (c,) arrays
    """

    row: Ints
    shape: Floats
    rss: Floats

    def choose_best(self) -> Floats:
        """The shape with the least sum of squares of each group, (g,)."""
        least = np.full(int(self.row.max()) + 1, np.inf)
        np.minimum.at(least, self.row, self.rss)
        # Of equally good shapes the largest: the roughest surface extrapolates the least.
        equal = self.rss <= least[self.row] * (1 + EQUAL)
        best = np.full(len(least), -np.inf)
        np.maximum.at(best, self.row[equal], self.shape[equal])
        return best


def find_minima(projection: Projection, close: float = CLOSE) -> Minima:
    """The deepest dips of each group's sum of squares, refined to the last digits.

    Parameters
    ----------
    projection : Projection
    close : float
        Relative error of a shape that will do.
    """
    scan = projection.model.search(projection.angle)
    cost = scan_rss(projection, scan)
    row, place = _find_dips(cost)
    last = scan.shape[1] - 1
    about = np.stack((np.maximum(place - 1, 0), place, np.minimum(place + 1, last)), axis=-1)
    near = scan[0][about] if len(scan) == 1 else scan[row[:, None], about]
    dips = projection.take(row)
    slope = dips.gradient(near)
    # The zero of the gradient is known to full precision, the minimum itself to half of it.
    noise = EQUAL * cost[row, place][:, None] / near
    dip, side = np.nonzero((slope < -noise)[:, :-1] & (slope > noise)[:, 1:])
    roots = find_roots(
        lambda shape, which: dips.take(dip[which]).gradient(shape),
        near[dip, side],
        near[dip, side + 1],
        (slope[dip, side], slope[dip, side + 1]),
        close,
    )
    # A dip without a turn lies at an end of the search, or is a plateau.
    still = np.setdiff1d(np.arange(len(row)), dip)
    rows = np.concatenate((row[still], row[dip]))
    shapes = np.concatenate((near[still, 1], roots))
    return Minima(rows, shapes, projection.take(rows).rss(shapes))


def scan_rss(projection: Projection, scan: Floats) -> Floats:
    """Sums of squares, (g, s), at the trial shapes `scan`, (g or 1, s)."""
    if projection.value.size <= FEW:
        return projection.rss(scan)
    from app.core.kernels.fit_scan import scan_groups

    rss = np.empty((len(projection), scan.shape[1]))
    shared = len(scan) == 1 and len(projection.angle) == 1 and projection.is_free
    cells = scan.shape[1] * projection.value.shape[1] * projection.freedom.directions.shape[-1]
    size = len(rss) if shared else max(1, TABLE // cells)
    for first in range(0, len(rss), size):
        rows = np.arange(first, min(first + size, len(rss)))
        some = projection.take(rows)
        columns, target = some.tabulate(scan if len(scan) == 1 else scan[rows])
        bounds = np.stack((some.freedom.lower, some.freedom.upper), axis=-2)
        target = np.broadcast_to(target, (len(rows), *target.shape[1:]))
        scan_groups(columns, target, some.root, bounds, rss[rows[0] : rows[-1] + 1])
    return rss


def _find_dips(rss: Floats) -> tuple[Ints, Ints]:
    """Rows and places, (c,), of the deepest dips; a plateau counts once, with its last shape."""
    wall = np.full((len(rss), 1), np.inf)
    walled = np.hstack((wall, rss, wall))
    falls = rss <= walled[:, :-2] * (1 + EQUAL)
    row, place = np.nonzero(falls & (rss * (1 + EQUAL) < walled[:, 2:]))
    order = np.lexsort((place, rss[row, place], row))
    row, place = row[order], place[order]
    rank = np.arange(len(row)) - np.searchsorted(row, row)
    return row[rank < CANDIDATES], place[rank < CANDIDATES]


def polish(full: Projection, rough: Projection, shape: float, limits: tuple[float, float]) -> float:
    """The minimum of all pairs of one group beside that of its condensed pairs.

    Secants, begun with the bend of the condensed sum of squares; a bracket where they fail.
    """
    nudged = np.clip(shape * (1 + NUDGE * np.array([[-1.0, 1.0]])), *limits)
    bend = float(np.diff(rough.gradient(nudged))[0, 0] / np.diff(nudged)[0, 0])
    here, last = shape, _slope(full, shape)
    for _ in range(SECANTS):
        if last == 0.0:
            return here
        if not bend > 0.0:
            break
        there = float(np.clip(here - last / bend, *limits))
        if abs(there - here) <= SETTLED * here:
            return there
        before, last = last, _slope(full, there)
        bend, here = (last - before) / (there - here), there
    return _bracket(full, shape, limits)


def _bracket(full: Projection, shape: float, limits: tuple[float, float]) -> float:
    """Least sum of squares about `shape`, within a bracket that holds a minimum."""
    low, high = _surround(full, shape, limits)
    at = _slope(full, low), _slope(full, high)
    if not at[0] < 0 < at[1]:
        found = [low, shape, high]
    else:
        ends = (np.array([low]), np.array([high]))
        values = (np.array([at[0]]), np.array([at[1]]))
        found = [low, high, *find_roots(lambda x, _: full.gradient(x), *ends, values)]
    return min(map(float, found), key=lambda x: float(full.rss(np.array([x]))[0]))


def _surround(full: Projection, shape: float, limits: tuple[float, float]) -> tuple[float, float]:
    """A bracket around a minimum that is known well but not quite."""
    share = MISPLACED
    while True:
        low, high = max(shape * (1 - share), limits[0]), min(shape * (1 + share), limits[1])
        falls_in = low == limits[0] or _slope(full, low) <= 0
        if (falls_in and (high == limits[1] or _slope(full, high) >= 0)) or share >= 1:
            return low, high
        share *= 10


def _slope(full: Projection, shape: float) -> float:
    return float(full.gradient(np.array([shape]))[0])
