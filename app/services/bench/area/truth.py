"""What is true of simulated leaves: area, tilt, and how much of them the scanner sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.units import to_degrees
from app.simulate.simulation import Simulation
from app.simulate.surfaces import Leaf

SIDE = 160
"""Places along and across a leaf that its area is summed over."""
NUDGE = 1e-6
"""Metres: for slopes of a leaf's height."""
HIDES = 0.0005
"""Metres that another surface must lie in front of a place to hide it."""


@dataclass(frozen=True, slots=True)
class TrueLeaf:
    """A leaf's kind, area (square metres), mean angle (degrees), share seen and range."""

    kind: str
    area: float
    omega: float
    seen: float
    distance: float


def lift_height(leaf: Leaf, x: Floats, y: Floats) -> Floats:
    """Height of a leaf over its plane, metres (see `app.simulate.surfaces.Leaf`)."""
    height = np.zeros_like(x)
    if leaf.curvature:
        along = x * np.cos(leaf.bend_direction) + y * np.sin(leaf.bend_direction)
        height = (1 - np.sqrt(1 - (leaf.curvature * along) ** 2)) / leaf.curvature
    if leaf.wrinkle_height:
        k = 2 * np.pi / np.array(leaf.wrinkle_lengths)
        wave = np.sin(k[0] * x + leaf.wrinkle_phases[0]) * np.sin(k[1] * y + leaf.wrinkle_phases[1])
        height = height + leaf.wrinkle_height * wave
    return height


def spread_leaf(leaf: Leaf) -> tuple[Floats, Floats, Floats]:
    """Places all over a leaf (n, 3), the area that each stands for (n,), and normals (n, 3)."""
    if leaf.lobes:
        raise BadInput("Lobed leaves have no closed form here.", "Take flat, bent or wrinkled.")
    share = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    s, t = np.meshgrid(share, share, indexing="ij")
    half = leaf.width / 2 * (1 - leaf.taper * s) * np.sqrt(1 - s * s)
    x, y = s * leaf.length / 2, t * half
    cell = (leaf.length / SIDE) * (2 * half / SIDE)
    slope = [
        (lift_height(leaf, x + a, y + b) - lift_height(leaf, x - a, y - b)) / (2 * NUDGE)
        for a, b in ((NUDGE, 0.0), (0.0, NUDGE))
    ]
    along, across, up = leaf.frame()
    local = np.stack([x, y, lift_height(leaf, x, y)], axis=-1)
    places = np.array(leaf.centre) + local @ np.stack([along, across, up])
    normals = up - slope[0][..., None] * along - slope[1][..., None] * across
    areas = cell * np.sqrt(1 + slope[0] ** 2 + slope[1] ** 2)
    return places.reshape(-1, 3), areas.ravel(), normals.reshape(-1, 3)


def tell_leaves(made: Simulation) -> list[TrueLeaf]:
    """Truth of all leaves of a simulated scan."""
    grid = made.scan.grid
    if grid is None:
        raise BadInput("The simulated scan has no rows and columns.")
    scanner = made.scan.scanner("the truth of its leaves")
    # Leaves cross: what a beam meets first is told by its surface, not by how near it is.
    front = np.full((grid.rows, grid.columns), np.inf)
    owner = np.full((grid.rows, grid.columns), -1)
    ahead = np.argsort(-made.scan.attributes["truth_range"], kind="stable")
    cell = grid.row[ahead], grid.column[ahead]
    front[cell] = made.scan.attributes["truth_range"][ahead]
    owner[cell] = made.scan.attributes["truth_leaf"][ahead]
    up, side = _angles(made.scan.xyz - scanner)
    to_row, to_column = np.polyfit(up, grid.row, 1), np.polyfit(side, grid.column, 1)
    found = []
    for number, leaf in enumerate(made.scene.leaves):
        places, areas, normals = spread_leaf(leaf)
        beams = places - scanner
        away = np.linalg.norm(beams, axis=1)
        up, side = _angles(beams)
        row = np.rint(np.polyval(to_row, up)).astype(np.int64)
        column = np.rint(np.polyval(to_column, side)).astype(np.int64)
        inside = (row >= 0) & (row < grid.rows) & (column >= 0) & (column < grid.columns)
        seen = np.zeros(len(away), np.bool_)
        there = row[inside], column[inside]
        seen[inside] = (owner[there] == number) | (front[there] > away[inside] - HIDES)
        across = np.linalg.norm(np.cross(beams, normals), axis=1)
        omega = np.arctan2(across, np.abs((beams * normals).sum(axis=1)))
        total = float(areas.sum())
        kind = "wrinkled" if leaf.wrinkle_height else "bent" if leaf.curvature else "flat"
        found.append(
            TrueLeaf(
                kind, total, float(to_degrees(np.average(omega, weights=areas))),
                float((areas * seen).sum() / total), float(away.mean()),
            )
        )  # fmt: skip
    return found


def _angles(beams: Floats) -> tuple[Floats, Floats]:
    x, y, z = beams.T
    return np.arctan2(z, np.hypot(x, y)), np.arctan2(y, x)
