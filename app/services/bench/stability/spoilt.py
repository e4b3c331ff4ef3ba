"""Scans that are too small, spoilt, at a border or odd: the true angle, or none."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from app.core.arrays import Floats
from app.core.neighbours.steps import Cells
from app.services.bench.stability.patches import (
    STEP,
    Patch,
    center_steps,
    make_leaves,
    make_plane,
    make_pole,
    number_cells,
    point,
    see_plane,
    spread_beams,
)
from app.services.bench.stability.ways import (
    Case,
    Outcome,
    Way,
    compare,
    compare_known,
    expect_none,
)

EXACT = 1e-6
"""Degrees."""
LINEAR = 0.01
"""Degrees: rows and columns are not quite the coordinates in which 1 / range is linear."""
TILTED = 40.0
BORDER = 3
"""Cells from the border within which windows are cut."""
SPOILT = (np.nan, np.inf, -np.inf, 0.0)


def list_spoilt() -> list[Case]:
    """All of them."""
    tilts = [
        Case("zero noise", f"a plane at {tilt:g}°", LINEAR, partial(see_exactly, tilt=tilt))
        for tilt in (0.0, 30.0, 60.0, 75.0)
    ]
    return [
        Case("few points", "one point", 0.0, partial(keep_few, count=1)),
        Case("few points", "two points", 0.0, partial(keep_few, count=2)),
        Case("few points", "three points: their plane, or none", EXACT, keep_three),
        Case("few points", "points on one line", 0.0, keep_line),
        Case("few points", "one return among holes", 0.0, leave_alone),
        Case("duplicates", "each point twice", LINEAR, double),
        *tilts,
        Case("grazing", "a plane at 85°: its angle, or none", LINEAR, see_grazing),
        Case("spoilt", "NaN, infinite and zero ranges among the others", EXACT, spoil),
        Case("borders", "windows that the grid's border cuts", LINEAR, look_at_border),
        Case("poles", "about elevation 90°", LINEAR, partial(look_at_pole, below=False)),
        Case("poles", "about elevation −90°", LINEAR, partial(look_at_pole, below=True)),
        Case("grids", "beams beside their rows and columns (0.3 steps)", LINEAR, jitter),
        Case("grids", "the step doubles half way", LINEAR, change_step),
        Case("grids", "rows and columns of another scan", LINEAR, mix_cells),
        Case("grazing", "a plane through the scanner: 90°, or none", EXACT, graze),
    ]


def see_exactly(way: Way, side: int, tilt: float) -> Outcome:
    """All points of a plane without noise."""
    patch = make_plane(tilt, side)
    return compare(way.angles(patch), patch.omega)


def see_grazing(way: Way, side: int) -> Outcome:
    """Ranges differ by more from cell to cell than at many an edge."""
    patch = make_plane(85.0, side)
    return compare_known(way.angles(patch), patch.omega)


def keep_few(way: Way, side: int, count: int) -> Outcome:
    """Points beside each other, and nothing else."""
    patch = make_plane(TILTED, side)
    middle = side * side // 2 + side // 2
    return expect_none(way.angles(patch.take(middle + np.arange(count))))


def keep_three(way: Way, side: int) -> Outcome:
    """Three corners of a cell."""
    patch = make_plane(TILTED, side)
    middle = side * side // 2 + side // 2
    few = patch.take(np.array([middle, middle + 1, middle + side]))
    return compare_known(way.angles(few), few.omega)


def keep_line(way: Way, side: int) -> Outcome:
    """One row of points, on one line in space."""
    patch = make_plane(TILTED, side)
    along = np.linspace(-0.02, 0.02, side)[:, None] * np.array([0.3, 1.0, 0.0])
    row, column = np.full(side, side // 2, np.int32), np.arange(side, dtype=np.int32)
    line = replace(
        patch, xyz=np.array([2.0, 0.0, 0.0]) + along, grid=Cells(side, side, row, column)
    )
    return expect_none(way.angles(line))


def leave_alone(way: Way, side: int) -> Outcome:
    """A point far from all others, in the middle of holes."""
    patch = make_plane(TILTED, side)
    middle = side // 2
    off = np.maximum(np.abs(patch.grid.row - middle), np.abs(patch.grid.column - middle))
    kept = patch.take((off == 0) | (off > side // 3))
    alone = np.flatnonzero((kept.grid.row == middle) & (kept.grid.column == middle))
    # So near that even the largest window, ten radii, reaches no other point.
    near = kept.xyz.copy()
    near[alone] *= 0.25
    return expect_none(way.angles(kept.put(near))[alone])


def double(way: Way, side: int) -> Outcome:
    """Each point again in the same cell; all copies have the angle that they had before."""
    patch = make_plane(TILTED, side)
    twice = patch.take(np.repeat(np.arange(len(patch.xyz)), 2))
    return compare(way.angles(twice), np.repeat(patch.omega, 2))


def spoil(way: Way, side: int) -> Outcome:
    """Spoilt points have no angle, and the others the one that they have without them."""
    patch = make_leaves(side)
    random = np.random.default_rng(1)
    bad = random.random(len(patch.xyz)) < 0.05
    xyz = patch.xyz.copy()
    kind = random.choice(SPOILT, int(bad.sum()))
    xyz[bad] = np.where(kind == 0.0, 0.0, 1.0)[:, None] * xyz[bad]
    xyz[np.flatnonzero(bad)[kind != 0.0], random.integers(0, 3)] = kind[kind != 0.0]
    found = way.angles(patch.put(xyz))
    if np.isfinite(found[bad]).any():
        return Outcome(90.0, len(found))
    return compare(found[~bad], way.angles(patch.take(~bad)))


def look_at_border(way: Way, side: int) -> Outcome:
    """Points of the outermost rows and columns."""
    patch = make_plane(TILTED, side)
    inner = [(a >= BORDER) & (a < side - BORDER) for a in (patch.grid.row, patch.grid.column)]
    border = ~(inner[0] & inner[1])
    return compare(way.angles(patch)[border], patch.omega[border])


def look_at_pole(way: Way, side: int, below: bool) -> Outcome:
    """All points about a pole, the row of points on the very pole too."""
    patch = make_pole(side // 2, below)
    return compare(way.angles(patch), patch.omega)


def _see_tilted(beams: Floats, grid: Cells) -> Patch:
    tilt = np.deg2rad(TILTED)
    normal = np.array([np.cos(tilt), 0.8 * np.sin(tilt), 0.6 * np.sin(tilt)])
    return see_plane(beams, grid, normal, 2.0 * float(normal[0]))


def jitter(way: Way, side: int) -> Outcome:
    """Beams that point up to 0.3 steps beside where their row and column say."""
    random = np.random.default_rng(2)
    up, left = (
        a.ravel() for a in np.meshgrid(center_steps(side), center_steps(side), indexing="ij")
    )
    off = random.uniform(-0.3 * STEP, 0.3 * STEP, (2, len(up)))
    patch = _see_tilted(point(up + off[0], left + off[1]), number_cells(side, side))
    return compare(way.angles(patch), patch.omega)


def change_step(way: Way, side: int) -> Outcome:
    """Rows of the lower half lie twice as far apart: no single step is right."""
    step = np.where(np.arange(side) < side // 2, STEP, 2.0 * STEP)
    beams, grid = spread_beams(-np.cumsum(step), center_steps(side))
    patch = _see_tilted(beams, grid)
    return compare(way.angles(patch), patch.omega)


def mix_cells(way: Way, side: int) -> Outcome:
    """Rows and columns that belong to other points must be found out, and not be used."""
    patch = make_plane(TILTED, side)
    order = np.random.default_rng(3).permutation(len(patch.xyz))
    cells = replace(patch.grid, row=patch.grid.row[order], column=patch.grid.column[order])
    wrong = replace(patch, grid=cells)
    return compare(way.angles(wrong), patch.omega)


def graze(way: Way, side: int) -> Outcome:
    """Points in a plane that holds the scanner too: one column of beams, at many ranges."""
    up = np.repeat(center_steps(side), 8)
    ranges = np.tile(2.0 + 0.0007 * np.arange(8), side)
    beams = point(up, np.zeros(len(up)))
    row = np.repeat(np.arange(side), 8).astype(np.int32)
    cells = Cells(side, side, row, np.full(len(up), side // 2, np.int32))
    patch = Patch(ranges[:, None] * beams, np.zeros(3), cells, np.full(len(up), 90.0))
    return compare_known(way.angles(patch), patch.omega)
