"""Small scans whose every angle is known, to be moved, turned, thinned and spoilt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.neighbours.steps import Cells
from app.core.units import to_degrees

STEP = 3.2e-4
"""Radians between beams."""
NOISE = 0.0007
"""Metres, along the beam."""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A scan: points, where they were seen from, their cells, and the true angles, degrees."""

    xyz: Floats
    scanner: Floats
    grid: Cells
    omega: Floats

    def take(self, kept: AnyArray) -> Patch:
        """Some of the points, (k,) numbers or (n,) booleans, in the same grid."""
        cells = replace(self.grid, row=self.grid.row[kept], column=self.grid.column[kept])
        return Patch(self.xyz[kept], self.scanner, cells, self.omega[kept])

    def put(self, xyz: Floats) -> Patch:
        """The same cells with other points."""
        return replace(self, xyz=xyz)


def spread_beams(elevation: Floats, azimuth: Floats) -> tuple[Floats, Cells]:
    """Beams of all rows × columns, (n, 3), and their cells; radians."""
    up, side = (a.ravel() for a in np.meshgrid(elevation, azimuth, indexing="ij"))
    return point(up, side), number_cells(len(elevation), len(azimuth))


def point(up: Floats, side: Floats) -> Floats:
    """Unit vectors of elevations and azimuths."""
    flat = np.cos(up)
    return np.stack([flat * np.cos(side), flat * np.sin(side), np.sin(up)], axis=1)


def number_cells(rows: int, columns: int) -> Cells:
    """Every cell of a grid once."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:rows, :columns])
    return Cells(rows, columns, row, column)


def center_steps(side: int, step: float = STEP) -> Floats:
    """Angles of `side` lines about 0, from high to low."""
    return np.asarray(step * ((side - 1) / 2 - np.arange(side)), np.float64)


def turn_round(columns: int) -> Floats:
    """Azimuths of a whole turn, from left to right."""
    return np.asarray(np.pi - 2.0 * np.pi * (np.arange(columns) + 0.5) / columns, np.float64)


def see_plane(beams: Floats, grid: Cells, normal: Floats, offset: float) -> Patch:
    """Where beams from the origin meet the plane normal · P = offset."""
    facing = beams @ normal
    xyz = (offset / facing)[:, None] * beams
    across = np.linalg.norm(np.cross(beams, normal), axis=1)
    return Patch(xyz, np.zeros(3), grid, to_degrees(np.arctan2(across, np.abs(facing))))


def make_plane(degrees: float, side: int, distance: float = 2.0) -> Patch:
    """A plane whose middle is met at `degrees`, turned about neither rows nor columns."""
    tilt = np.deg2rad(degrees)
    normal = np.array([np.cos(tilt), np.sin(tilt) * 0.8, np.sin(tilt) * 0.6])
    beams, grid = spread_beams(center_steps(side), center_steps(side))
    return see_plane(beams, grid, normal, distance * float(normal[0]))


def make_leaves(side: int, seed: int = 0) -> Patch:
    """Two tilted planes and a ball before a wall, noise along the beam, holes here and there."""
    beams, grid = spread_beams(center_steps(side), center_steps(side))
    third = grid.column * 3 // side
    ranges = np.choose(
        third,
        [_reach_plane(beams, 0.7, 2.0), _reach_ball(beams, side), _reach_plane(beams, -1.1, 2.2)],
    )
    random = np.random.default_rng(seed)
    ranges = ranges + random.normal(0.0, NOISE, len(ranges))
    unknown = np.full(len(ranges), np.nan)
    whole = Patch(ranges[:, None] * beams, np.zeros(3), grid, unknown)
    return whole.take(random.random(len(ranges)) > 0.03)


def _reach_plane(beams: Floats, tilt: float, distance: float) -> Floats:
    normal = np.array([np.cos(tilt), 0.8 * np.sin(tilt), 0.6 * np.sin(tilt)])
    return np.asarray(distance * normal[0] / (beams @ normal))


def _reach_ball(beams: Floats, side: int) -> Floats:
    """A ball that fills the field up and down, and a wall behind it."""
    radius = 2.1 * STEP * side / 2
    centre = np.array([2.1 + radius, 0.0, 0.0])
    along = beams @ centre
    inside = along**2 - centre @ centre + radius**2
    near = along - np.sqrt(np.maximum(inside, 0.0))
    return np.where(inside > 0.0, near, 3.0 / beams[:, 0])


def make_pole(side: int, below: bool = False) -> Patch:
    """A level ceiling (or floor) about the very pole, seen all around; rows end at ±90°."""
    elevation = np.asarray(np.pi / 2 - 2.0 * STEP * np.arange(side), np.float64)
    azimuth = turn_round(6 * side)
    beams, grid = spread_beams(-elevation if below else elevation, azimuth)
    tilt = np.array([0.3, 0.2, 1.0])
    return see_plane(beams, grid, tilt, -1.5 if below else 1.5)


def make_round(side: int, seed: int = 0) -> Patch:
    """A whole turn about the scanner: an eight-sided room, with noise."""
    elevation, azimuth = center_steps(side, 0.004), turn_round(8 * side)
    beams, grid = spread_beams(elevation, azimuth)
    wall = np.floor(np.arctan2(beams[:, 1], beams[:, 0]) / (np.pi / 4) + 0.5) * (np.pi / 4)
    facing = beams[:, 0] * np.cos(wall) + beams[:, 1] * np.sin(wall)
    ranges = 1.0 / facing + np.random.default_rng(seed).normal(0.0, NOISE, len(facing))
    unknown = np.full(len(ranges), np.nan)
    return Patch(ranges[:, None] * beams, np.zeros(3), grid, unknown)
