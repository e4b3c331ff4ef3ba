"""The steps of a scan grid, found in the directions of some of its points.

Beams on a lattice are a wave: the Fourier transform of their directions has a peak at one over
the step, however many cells are empty (as crystals are measured by their reciprocal lattice).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.neighbours.steps import UnusableGrid

NO_LINES = "the directions of the points do not lie on rows and columns"
FINE = 8
"""Bins per mean distance of two beams."""
WIDE = 64
"""Mean distances of two beams that a window is wide."""
LONGEST = 7
"""Mean distances of two beams that a step may have at most."""
WINDOWS = 9
TRIED = 3
"""Windows after which a scan without any wave is given up."""
ENOUGH = 60
COHERENT = 0.3
CHANCE = 4.5
"""Times 1 / √n: the highest peak that chance makes among all of a window's."""
FUNDAMENTAL = 0.6
LEAN = 0.3
"""Tangent of the angle by which rows and columns may lean in a window."""
AGREE = 0.02
AGAIN = 2
STEEPEST = 1.2
MOST_TILT = 0.3
TILT_ERROR, USUAL_TILT = 1e-3, 0.05
_Pair = tuple[Floats | None, Floats | None]


@dataclass(frozen=True, slots=True, eq=False)
class Waves:
    """Rows and columns per radian, and the axes about which rows are level.

    Attributes
    ----------
    axes : (3, 3)
        The scanner's axes, as rows.
    rows : (2,)
        Rows per radian of elevation and of azimuth.
    columns : (2,)
        Columns per radian of elevation and of azimuth.
    """

    axes: Floats
    rows: Floats
    columns: Floats


def find_waves(beams: Floats, per_sample: float) -> Waves:
    """Find the steps of rows and columns in sampled directions.

    Parameters
    ----------
    beams : (3, m)
        Azimuth and elevation, radians, and range of sampled points.
    per_sample : float
        Points of the scan per sampled one.

    Raises
    ------
    UnusableGrid
        There are none, or they differ from place to place.
    """
    waves = _find_once(beams, per_sample)
    for _ in range(AGAIN):
        if np.array_equal(waves.axes, np.eye(3)):
            break
        # About a leaning axis lines bend within a window: look again about the right one.
        again = _find_once(_turn(beams, waves.axes), per_sample)
        axes = again.axes @ waves.axes
        done = np.array_equal(again.axes, np.eye(3))
        waves = Waves(axes, again.rows, again.columns)
        if done:
            break
    return waves


def _turn(beams: Floats, axes: Floats) -> Floats:
    """The same beams about other axes."""
    flat = np.cos(beams[1])
    level = axes @ np.stack([flat * np.cos(beams[0]), flat * np.sin(beams[0]), np.sin(beams[1])])
    elevation = np.arctan2(level[2], np.hypot(level[0], level[1]))
    return np.stack([np.arctan2(level[1], level[0]), elevation, beams[2]])


def _find_once(beams: Floats, per_sample: float) -> Waves:
    found, seen = [], []
    for centre, distance in _choose_windows(beams, per_sample):
        row, column = _measure_window(beams, centre, distance)
        seen.append((row is not None, column is not None))
        if row is not None and column is not None:
            found.append((centre, row, column))
        if len(seen) == TRIED and not found:
            break
    if not found or 2 * len(found) < len(seen):
        _refuse(*np.sum(seen, axis=0))
    centres, rows, columns = (np.array(part) for part in zip(*found, strict=True))
    return _join(centres, rows, columns)


def _refuse(rows: int, columns: int) -> None:
    if columns > rows:
        raise UnusableGrid("columns are regular, but rows do not line up from one to the next")
    if rows > columns:
        raise UnusableGrid("rows are regular, but columns do not line up from one to the next")
    raise UnusableGrid(NO_LINES)


def _choose_windows(beams: Floats, per_sample: float) -> list[tuple[Floats, float]]:
    """Centres of well-filled windows, far apart, and the mean distance of beams in each.

    Directions are equally dense in azimuth and sine of elevation. Windows lie where points are
    far: near ones are spoilt by rounded coordinates.
    """
    level = np.abs(beams[1]) < STEEPEST
    azimuth, height = beams[0, level], np.sin(beams[1, level])
    if len(azimuth) < ENOUGH:
        raise UnusableGrid("too few points to find rows and columns by")
    bins = int(np.clip(np.sqrt(len(azimuth) / 30), 4, 96))
    size = max(float(np.ptp(azimuth)), float(np.ptp(height)), 1e-12) / bins * (1.0 + 1e-9)
    across = ((azimuth - azimuth.min()) / size).astype(np.int64)
    key = across * (bins + 1) + ((height - height.min()) / size).astype(np.int64)
    count = np.bincount(key)
    reach = np.bincount(key, beams[2, level]) / np.maximum(count, 1)
    full = np.flatnonzero(count >= 0.5 * np.quantile(count[key], 0.75))
    order = full[np.argsort(-reach[full], kind="stable")]
    order = order[: max(WINDOWS, len(order) // 2)]
    picked = order[np.unique(np.linspace(0, len(order) - 1, WINDOWS).astype(np.int64))]
    windows = []
    for k in picked:
        inside = key == k
        centre = np.array([np.median(azimuth[inside]), np.arcsin(np.median(height[inside]))])
        windows.append((centre, float(np.sqrt(size**2 / (count[k] * per_sample)))))
    return windows


def _measure_window(beams: Floats, centre: Floats, distance: float) -> _Pair:
    """Waves of rows and of columns, each (east, north) per radian, or None."""
    half = WIDE / 2 * distance
    turn = np.remainder(beams[0] - centre[0] + np.pi, 2 * np.pi) - np.pi
    inside = (np.abs(turn) * np.cos(centre[1]) < half) & (np.abs(beams[1] - centre[1]) < half)
    if np.count_nonzero(inside) < ENOUGH:
        return None, None
    # Columns come closer towards a pole: cos of each point's own elevation would bend them.
    place = np.stack([turn[inside] * np.cos(centre[1]), beams[1, inside] - centre[1]], axis=1)
    spectrum = _transform(place, distance)
    least = max(COHERENT, CHANCE / np.sqrt(len(place)))
    row, column = (_find_peak(spectrum, least, across) for across in (0, 1))
    window = WIDE * distance
    return (
        None if row is None else _sharpen(place, row / window),
        None if column is None else _sharpen(place, column / window),
    )


def _transform(place: Floats, distance: float) -> Floats:
    """Size of the Fourier transform of a window's directions; 1 for a perfect lattice."""
    from scipy.fft import rfft2

    size = WIDE * FINE
    cell = np.floor(place * (FINE / distance)).astype(np.int64) + size // 2
    np.clip(cell, 0, size - 1, out=cell)
    image = np.bincount(cell[:, 1] * size + cell[:, 0], minlength=size * size)
    spectrum: Floats = np.abs(rfft2(image.reshape(size, size).astype(np.float32)))
    spectrum /= len(place)
    return spectrum


@cache
def _wedges() -> tuple[tuple[Bools, Bools], Floats]:
    """Where in a spectrum waves up a window and across it lie, and how long waves are."""
    size = WIDE * FINE
    north = np.abs(np.fft.fftfreq(size, 1 / size))[:, None]
    east = np.arange(size // 2 + 1)[None, :]
    up = (north >= WIDE / LONGEST) & (east <= LEAN * north)
    side = (east >= WIDE / LONGEST) & (north <= LEAN * east)
    return (up, side), np.hypot(north, east)


def _find_peak(spectrum: Floats, least: float, across: int) -> Floats | None:
    """The longest wave, (east, north) per window, up the window (0) or across it (1)."""
    wedges, length = _wedges()
    heights = np.where(wedges[across], spectrum, np.float32(0.0))
    top = float(heights.max())
    if top < least:
        return None
    high = np.flatnonzero(heights >= max(FUNDAMENTAL * top, least))
    n, e = divmod(int(high[np.argmin(length.ravel()[high])]), heights.shape[1])
    for _ in range(4):
        around = [(a % len(heights), b) for a in range(n - 2, n + 3) for b in range(e - 2, e + 3)]
        around = [(a, b) for a, b in around if 0 <= b < heights.shape[1]]
        n, e = max(around, key=lambda at: heights[at])
    wave = np.array([float(e), float(n if 2 * n < len(heights) else n - len(heights))])
    return wave if wave[1 - across] > 0 else -wave


def _sharpen(place: Floats, wave: Floats) -> Floats:
    """Fit the wave to the phases that it leaves."""
    for _ in range(3):
        phase = place @ wave
        centre = np.angle(np.exp(2j * np.pi * phase).mean()) / (2 * np.pi)
        rest = phase - centre
        rest -= np.round(rest)
        near = np.abs(rest) < 0.3
        table = np.column_stack([place[near], np.ones(np.count_nonzero(near))])
        wave = wave - np.linalg.lstsq(table, rest[near], rcond=None)[0][:2]
    return wave


def _join(centres: Floats, rows: Floats, columns: Floats) -> Waves:
    """One lattice out of those of the windows; raises `UnusableGrid` where they disagree."""
    axes = _find_axes(centres, rows)
    east, north, up = _compass(centres)
    level = np.stack([up @ axes[0], up @ axes[1], up @ axes[2]], axis=1)
    azimuth, elevation = np.arctan2(level[:, 1], level[:, 0]), np.arcsin(level[:, 2])
    new_east, new_north, _ = _compass(np.stack([azimuth, elevation], axis=1))
    lines = []
    for wave in (rows, columns):
        slope = (wave[:, :1] * east + wave[:, 1:] * north) @ axes.T
        turn = (slope * new_east).sum(axis=1) * np.cos(elevation)
        lines.append(np.stack([(slope * new_north).sum(axis=1), turn], axis=1))
    main = np.stack([lines[0][:, 0], lines[1][:, 1]], axis=1)
    typical = np.median(main, axis=0)
    agree = (np.abs(main / typical - 1.0) < AGREE).all(axis=1)
    if agree.sum() < max(1, 0.6 * len(agree)):
        raise UnusableGrid("the steps between the points' directions differ from place to place")
    return Waves(axes, *(np.median(line[agree], axis=0) for line in lines))


def _compass(centres: Floats) -> tuple[Floats, Floats, Floats]:
    """East, north and outward unit vectors at directions (w, 2)."""
    (ca, ce), (sa, se) = np.cos(centres).T, np.sin(centres).T
    east = np.stack([-sa, ca, np.zeros_like(sa)], axis=1)
    return (
        east,
        np.stack([-se * ca, -se * sa, ce], axis=1),
        np.stack([ce * ca, ce * sa, se], axis=1),
    )


def _find_axes(centres: Floats, rows: Floats) -> Floats:
    """Axes whose third is square to the rows; where windows do not tell, nearly upright."""
    east, north, up = _compass(centres)
    along = np.cross(up, rows[:, :1] * east + rows[:, 1:] * north)
    along /= np.linalg.norm(along, axis=1)[:, None]
    weak = (TILT_ERROR / USUAL_TILT) ** 2
    square = along[:, :2].T @ along[:, :2] + weak * np.eye(2)
    lean = np.linalg.solve(square, -along[:, :2].T @ along[:, 2])
    if not np.hypot(*lean) < MOST_TILT:
        raise UnusableGrid("the rows are not level: the scanner lay on its side, or has no rows")
    if np.hypot(*lean) < TILT_ERROR:
        return np.eye(3)
    axis = np.append(lean, 1.0) / np.linalg.norm(np.append(lean, 1.0))
    first = np.cross([0.0, 1.0, 0.0], axis)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis])
