"""Changes of a whole scan that change no angle: moved, scaled, turned, mirrored, shuffled."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from app.core.arrays import Floats
from app.core.incidence import RADIUS
from app.core.neighbours.steps import Cells
from app.services.bench.stability.patches import Patch, make_leaves, make_round
from app.services.bench.stability.ways import Case, Outcome, Way, compare

EXACT = 1e-6
"""Degrees."""
FARTHEST = 2e-5
"""Degrees, at 10⁷ m, where a coordinate is rounded by 10⁻⁹ m."""
SINGLE = 0.01
"""Degrees: single precision rounds 2 m by 10⁻⁷ m, a part in 6000 of the noise."""
TILES = 0.1
"""Degrees, where tiles lie elsewhere: 'adaptive' takes its widths from bends averaged in them."""
MOST = 0.99
TURNS = range(4)
DIRECTION = np.array([0.61, -0.73, 0.31])


def list_changes() -> list[Case]:
    """All of them."""
    cases = [
        Case("moved", f"{offset:.0e} m away", _limit_at(offset), partial(shift, offset=offset))
        for offset in (1e3, 1e4, 1e5, 1e6, 1e7)
    ]
    cases += [
        Case("scaled", f"everything × {factor:g}", EXACT, partial(scale, factor=factor))
        for factor in (1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3)
    ]
    cases += [
        Case("rounded", f"{offset:.0e} m away", limit, partial(round_far, offset=offset))
        for offset, limit in ((1e3, EXACT), (1e6, EXACT), (1e7, FARTHEST))
    ]
    return [
        *cases,
        Case("turned", "scan and scanner turned and moved", EXACT, turn_often),
        Case("mirrored", "left and right changed", EXACT, mirror),
        Case("shuffled", "points in another order", EXACT, shuffle),
        Case("seam", "the first column elsewhere on a whole turn", TILES, roll),
        Case("rounded", "float32 points near the scanner", SINGLE, round_to_single),
    ]


def _limit_at(offset: float) -> float:
    return FARTHEST if offset > 1e6 else EXACT


def shift(way: Way, side: int, offset: float, seed: int = 0) -> Outcome:
    """Far coordinates against the same, rounded as they are, brought back exactly."""
    patch = make_leaves(side, seed)
    scanner = np.round(DIRECTION * offset)
    far = replace(patch, xyz=patch.xyz + scanner, scanner=scanner)
    # The difference of two near numbers is exact (Sterbenz 1974): the rounding is the same.
    near = patch.put(far.xyz - scanner)
    return compare(way.angles(far), way.angles(near))


def round_far(way: Way, side: int, offset: float, seed: int = 0) -> Outcome:
    """Far coordinates against those before they were rounded.

    A neighbour on the rim of a ball may fall on either side then, so that `MOST` of the points
    are looked at.
    """
    patch = make_leaves(side, seed)
    scanner = np.round(DIRECTION * offset)
    far = replace(patch, xyz=patch.xyz + scanner, scanner=scanner)
    return compare(way.angles(far), way.angles(patch), most=MOST)


def scale(way: Way, side: int, factor: float, seed: int = 0) -> Outcome:
    """All lengths, and the radius, times a factor."""
    patch = make_leaves(side, seed)
    scanner = np.array([0.3, -0.2, 1.6])
    patch = replace(patch, xyz=patch.xyz + scanner, scanner=scanner)
    other = replace(patch, xyz=patch.xyz * factor, scanner=scanner * factor)
    return compare(way.angles(other, RADIUS * factor), way.angles(patch))


def draw_turn(seed: int) -> Floats:
    """A random rotation, (3, 3)."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def turn(way: Way, side: int, seed: int = 0) -> Outcome:
    """A random rotation about the scanner, and a move of a few metres."""
    patch = make_leaves(side, seed)
    move = np.random.default_rng(seed).uniform(-5.0, 5.0, 3)
    other = replace(patch, xyz=patch.xyz @ draw_turn(seed).T + move, scanner=move)
    return compare(way.angles(other), way.angles(patch))


def turn_often(way: Way, side: int) -> Outcome:
    """The worst of some rotations, upright, leaning and upside down."""
    return max((turn(way, side, seed) for seed in TURNS), key=lambda outcome: outcome.worst)


def mirror(way: Way, side: int, seed: int = 0) -> Outcome:
    """The scan in a mirror; columns run the other way, as they would there."""
    patch = make_leaves(side, seed)
    grid = patch.grid
    column = np.ascontiguousarray(grid.columns - 1 - grid.column)
    cells = Cells(grid.rows, grid.columns, grid.row, column)
    other = replace(patch, xyz=patch.xyz * [1.0, -1.0, 1.0], grid=cells)
    return compare(way.angles(other), way.angles(patch))


def shuffle(way: Way, side: int, seed: int = 0) -> Outcome:
    """Points, with their cells where they have any, in random order."""
    patch = make_leaves(side, seed)
    order = np.random.default_rng(seed).permutation(len(patch.xyz))
    return compare(way.angles(patch.take(order)), way.angles(patch)[order])


ROUND = 0.02
"""Radius in the room, whose beams are far apart."""


def roll(way: Way, side: int, seed: int = 0) -> Outcome:
    """Where a whole turn begins must not matter."""
    patch = make_round(side // 4, seed)
    grid = patch.grid
    column = ((grid.column + grid.columns // 3) % grid.columns).astype(np.int32)
    other = replace(patch, grid=Cells(grid.rows, grid.columns, grid.row, column))
    return compare(way.angles(other, ROUND), way.angles(patch, ROUND))


def round_to_single(way: Way, side: int, seed: int = 0) -> Outcome:
    """Coordinates relative to the scanner, kept as float32; `MOST` of the points."""
    patch: Patch = make_leaves(side, seed)
    other = patch.put(patch.xyz.astype(np.float32).astype(np.float64))
    return compare(way.angles(other), way.angles(patch), most=MOST)
