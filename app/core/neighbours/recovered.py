"""The scan grid of a cloud without one, recovered from where its beams point.

The steps come from `waves`. What rows and columns shift against a perfect lattice (a leaning
axis, a head that turns while a column is scanned, an encoder's slow errors) is followed from
patch to patch, as phases are unwrapped. Nothing is believed before `proof` has tested it.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.neighbours.asked import as_points
from app.core.neighbours.proof import check_blocks, check_empty, check_places
from app.core.neighbours.steps import Cells, UnusableGrid
from app.core.neighbours.waves import NO_LINES, Waves, find_waves
from app.core.progress import QUIET, Progress

SAMPLES = 100_000
LEAST_SHARE = 10
"""One point in ten is sampled at least, so that windows of large scans hold enough."""
PER_PATCH = 64
"""Points of a full patch that its shift is measured by."""
LEAST_POINTS = 500
MARGIN = 64
FEW = 12
COHERENT = 0.5
TORN = 0.5
"""Steps between the shifts of patches that touch; a lost or gained step makes about one."""
MOST_TORN = 0.01
MOST_BENT = 0.75
"""Steps that lines may stray from those of a scanner that leans or drifts evenly."""
PIECE = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class Recovered:
    """A recovered scan grid.

    Attributes
    ----------
    cells : Cells
        Row 0 is the highest, column 0 the leftmost as the scanner sees it (or the first after
        the seam). Points without a range lie in the first cell.
    step : (2,) radians
        Of elevation and of azimuth.
    stray : (2,)
        Upper quartile of how far points lie from their row and column, in steps.
    """

    cells: Cells
    step: Floats
    stray: Floats


def recover_grid(xyz: Floats, scanner: Floats, progress: Progress = QUIET) -> Cells:
    """Find the row and the column of each point of an unordered single scan.

    Parameters
    ----------
    xyz : (n, 3) metres, in any order
    scanner : (3,) metres
    progress : Progress

    Raises
    ------
    UnusableGrid
        It has none, or it is doubtful; the text says why.
    Cancelled
    """
    return recover(xyz, scanner, progress).cells


def recover(xyz: Floats, scanner: Floats, progress: Progress = QUIET) -> Recovered:
    """Do what `recover_grid` does, and tell the steps too."""
    from app.core.kernels.recovered import sample_directions, start_rows

    xyz, scanner = as_points(xyz), np.array(scanner, dtype=np.float64)
    stride = max(1, len(xyz) // max(SAMPLES, len(xyz) // LEAST_SHARE))
    beams = sample_directions(xyz, scanner, stride)
    if beams.shape[1] < LEAST_POINTS:
        raise UnusableGrid("too few points to find rows and columns by")
    progress.report(0.1, "rows and columns")
    waves = find_waves(beams, stride)
    seen, lattice = _lay_lattice(_thin(beams, stride), waves)
    shift = _follow(seen, lattice)
    lattice = _set_cut(lattice, shift)
    places = _Places(len(xyz))
    places.fill(xyz, scanner, waves.axes, lattice, shift, progress.part(0.2, 0.9))
    stray = check_places(places.counts)
    top, bottom, left, right = (int(end) for end in places.ends)
    check_blocks(xyz, scanner, places.row, places.column, (bottom, right))
    rows, columns = bottom - top + 1, right - left + 1
    check_empty(rows, columns, len(xyz))
    start_rows(places.row, places.column, top, left)
    step = 1.0 / np.abs([waves.rows[0], waves.columns[1]])
    return Recovered(Cells(rows, columns, places.row, places.column), step, stray)


def _thin(beams: Floats, stride: int) -> Floats:
    from app.core.kernels.recovered import PATCH

    least = -(-beams.shape[1] // (SAMPLES // 4))
    return beams[:, :: max(1, min(PATCH**2 // (PER_PATCH * stride), least))]


def _lay_lattice(beams: Floats, waves: Waves) -> tuple[Floats, Floats]:
    """Samples as a first lattice sees them, (4, m), and that lattice; see `look`.

    Rows count downwards and columns to the right, from a cut at the widest gap in azimuth,
    with some room before the first.
    """
    from app.core.kernels.recovered import look

    flat, nowhere = np.cos(beams[1]), np.zeros(3)
    points = np.stack([flat * np.cos(beams[0]), flat * np.sin(beams[0]), np.sin(beams[1])], axis=1)
    level = points @ waves.axes.T
    cut = _find_cut(np.arctan2(level[:, 1], level[:, 0]))
    rows, columns = waves.rows, waves.columns
    lattice = np.array([cut, -rows[0], rows[1], 0.0, columns[1], -columns[0], 0.0])
    seen = np.empty((4, len(points)))
    look(points, nowhere, waves.axes, lattice, seen)
    for k, place in ((0, 3), (1, 6)):
        lattice[place] = MARGIN - float(np.floor(seen[k].min()))
        seen[k] += lattice[place]
    return seen, lattice


def _find_cut(azimuth: Floats) -> float:
    """The middle of the widest gap in azimuth, radians."""
    known = np.unique(np.round(azimuth, 4))
    gaps = np.diff(np.append(known, known[0] + 2 * np.pi))
    widest = int(np.argmax(gaps))
    return float(known[widest] + gaps[widest] / 2)


def _follow(seen: Floats, lattice: Floats) -> Floats:
    """How far lines lie from the lattice, (patches, patches, 2) steps."""
    from app.core.kernels.recovered import PATCH, follow_phases, sum_phases

    size = [int(seen[k].max() + MARGIN) // PATCH + 2 for k in (0, 1)]
    check_empty(size[0], size[1], seen.shape[1])
    down, across = np.zeros((*size, 3)), np.zeros((*size, 2))
    sum_phases(seen, down, across)
    count = down[:, :, 2]
    shift = np.stack(
        [np.arctan2(part[:, :, 1], part[:, :, 0]) / (2 * np.pi) for part in (down, across)], axis=2
    )
    clear = np.minimum(*(np.hypot(part[:, :, 0], part[:, :, 1]) for part in (down, across)))
    known = (count >= FEW) & (clear >= COHERENT * count)
    if count[known].sum() < 0.8 * count[count >= FEW].sum() or not known.any():
        raise UnusableGrid(NO_LINES)
    order = np.flatnonzero(known)
    order = order[np.argsort(-clear.ravel()[order], kind="stable")]
    trend = _find_trend(shift, known)
    shift -= trend
    shift -= np.round(shift)
    follow_phases(order, known, shift)
    if _count_torn(shift, known) > MOST_TORN * len(order):
        raise UnusableGrid("rows and columns are torn: two scans seem merged")
    shift += trend
    _check_bend(shift, known, lattice)
    return _fill_gaps(shift, known)


def _find_trend(shift: Floats, known: Bools) -> Floats:
    """The even part of the shifts, which an inexact step makes; (patches, patches, 2)."""
    trend = np.zeros_like(shift)
    for axis in (0, 1):
        both = known[1:] & known[:-1] if axis == 0 else known[:, 1:] & known[:, :-1]
        apart = np.diff(shift, axis=axis)[both]
        if len(apart):
            slope = np.median(apart - np.round(apart), axis=0)
            trend += np.indices(known.shape)[axis][:, :, None] * slope
    return trend


def _count_torn(shift: Floats, known: Bools) -> int:
    """Patches that touch although their shifts differ much."""
    torn = 0
    for axis in (0, 1):
        both = known[1:] & known[:-1] if axis == 0 else known[:, 1:] & known[:, :-1]
        apart = np.abs(np.diff(shift, axis=axis)).max(axis=2)
        torn += int(np.count_nonzero(apart[both] > TORN))
    return torn


def _check_bend(shift: Floats, known: Bools, lattice: Floats) -> None:
    """Refuse lines that no scanner makes: seen from elsewhere, straight lines bend.

    An instrument may lean, and its lines may drift evenly; what is left must be small.
    """
    from app.core.kernels.recovered import PATCH

    row, column = ((np.argwhere(known) + 0.5) * PATCH).T
    turn = (column - lattice[6]) / lattice[4]
    rise = np.clip((row - lattice[3]) / lattice[1], -1.3, 1.3)
    even = [np.ones_like(turn), turn, rise]
    leans = [np.cos(turn), np.sin(turn)]
    for k, steep in enumerate((np.ones_like(rise), np.tan(rise))):
        table = np.column_stack(even + [steep * lean for lean in leans])
        found = shift[known][:, k]
        rest = found - table @ np.linalg.lstsq(table, found, rcond=1e-9)[0]
        if np.quantile(np.abs(rest), 0.95) > MOST_BENT:
            raise UnusableGrid("rows and columns bend as no scanner's do from this position")


def _fill_gaps(shift: Floats, known: Bools) -> Floats:
    """Patches without a shift take that of the nearest one that has it."""
    from scipy.ndimage import distance_transform_edt

    p, q = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.ascontiguousarray(shift[p, q])


def _set_cut(lattice: Floats, shift: Floats) -> Floats:
    """Move the cut between two columns, so that it halves none where scans go all round."""
    from app.core.kernels.recovered import PATCH

    patch = int(lattice[6]) // PATCH
    if not 0 <= patch < shift.shape[1]:
        return lattice
    start = lattice[6] - float(np.median(shift[:, patch, 1]))
    move = np.floor(start) + 0.5 - start
    moved = lattice.copy()
    moved[0] -= move / lattice[4]
    moved[3] += lattice[2] * move / lattice[4]
    moved[6] += move
    return moved


class _Places:
    """Rows and columns as the threads fill them, and what they note on the way."""

    def __init__(self, total: int) -> None:
        from app.core.kernels.recovered import BINS

        self.row, self.column = np.empty(total, np.int32), np.empty(total, np.int32)
        self.counts: Ints = np.zeros((3, BINS), np.int64)
        self.ends: Ints = np.array([2**31, -(2**31), 2**31, -(2**31)])
        self._lock = threading.Lock()

    def fill(
        self, xyz: Floats, scanner: Floats, axes: Floats, lattice: Floats, shift: AnyArray,
        progress: Progress,
    ) -> None:  # fmt: skip
        from app.core.kernels.recovered import place_points

        def work(first: int, last: int) -> None:
            counts = np.zeros_like(self.counts)
            ends = np.array([2**31, -(2**31), 2**31, -(2**31)])
            place_points(
                xyz, scanner, axes, lattice, shift, first, last,
                self.row, self.column, counts, ends,
            )  # fmt: skip
            with self._lock:
                self.counts += counts
                self.ends[::2] = np.minimum(self.ends[::2], ends[::2])
                self.ends[1::2] = np.maximum(self.ends[1::2], ends[1::2])

        run_in_pieces(work, split_evenly(len(xyz), PIECE), progress, "rows and columns")
