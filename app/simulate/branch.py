"""The demo: a branch with pear-like leaves, and a row of leaves at known tilts, before a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.model.scan import Vector
from app.simulate.detector import Gloss, Material
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

LEAF: Material = (Gloss(0.48, 0.88, 0.22), Gloss(0.27, 0.72, 0.30))
"""A fresh leaf at 1063 and 1545 nm."""
BARK: Material = (Gloss(0.42), Gloss(0.38))
MATT: Material = (Gloss(0.60), Gloss(0.50))
SCANNER: Vector = (0.0, 0.0, 1.6)
TILTS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
"""Degrees; the row for teaching."""


def vector(values: Floats) -> Vector:
    """Three numbers as a plain tuple."""
    return float(values[0]), float(values[1]), float(values[2])


def water_leaf(random: np.random.Generator) -> Material:
    """A leaf a little wetter or drier than `LEAF`: water darkens 1545 nm, hardly 1063 nm."""
    near, short = LEAF
    wet = float(np.clip(random.normal(0.0, 0.12), -0.3, 0.3))
    return (
        replace(near, rho=near.rho * (1 + 0.03 * float(random.uniform(-1, 1)))),
        replace(short, rho=short.rho * (1 - wet)),
    )


def tilted_normal(centre: Floats, origin: Floats, tilt: float) -> Vector:
    """Normal that meets the beam to `centre` at `tilt` radians, turned about the vertical."""
    back = (origin - centre) / np.linalg.norm(origin - centre)
    side = np.cross([0.0, 0.0, 1.0], back)
    return vector(np.cos(tilt) * back + np.sin(tilt) * side / np.linalg.norm(side))


def tilted_row(centre: Floats, spacing: float, tilts_deg: tuple[float, ...]) -> tuple[Leaf, ...]:
    """Flat leaves side by side, tips down, tilted by known angles against the beam."""
    origin = np.array(SCANNER)
    places = (len(tilts_deg) - 1) / 2 - np.arange(len(tilts_deg))
    row = []
    for place, tilt in zip(places, tilts_deg, strict=True):
        middle = centre + np.array([0.0, place * spacing, 0.0])
        normal = tilted_normal(middle, origin, np.deg2rad(tilt))
        row.append(Leaf(vector(middle), (0.0, 0.0, -1.0), normal, 0.075, 0.05, LEAF, 0.3))
    return tuple(row)


def shape_leaf(leaf: Leaf, kind: int, random: np.random.Generator) -> Leaf:
    """The leaf flat (kind 0), bent (1) or wrinkled (2)."""
    if kind == 0:
        return leaf
    curved = replace(
        leaf,
        curvature=float(random.choice([-1, 1]) * random.uniform(5.0, 14.0)),
        bend_direction=float(random.choice([0.0, np.pi / 2]) + random.normal(0, 0.2)),
    )
    if kind == 1:
        return curved
    return replace(
        curved,
        curvature=curved.curvature / 4,
        wrinkle_height=float(random.uniform(0.0008, 0.002)),
        wrinkle_lengths=(float(random.uniform(0.02, 0.04)), float(random.uniform(0.02, 0.04))),
        wrinkle_phases=(float(random.uniform(0, 6.28)), float(random.uniform(0, 6.28))),
    )


def follow_branch(place: Floats) -> Floats:
    """Points of the main axis for places 0 (base, left and far) to 1 (tip, right and near)."""
    x = 3.35 - 0.95 * place
    y = 0.43 - 0.66 * place
    z = 1.545 + 0.195 * place - 0.17 * (place - 0.45) ** 2 + 0.012 * np.sin(9 * place)
    return np.stack([x, y, z], axis=-1)


def grow_axis() -> tuple[Stem, ...]:
    """The main axis, thinner towards its tip."""
    nodes = follow_branch(np.linspace(-0.15, 1.0, 24))
    radius = np.linspace(0.0075, 0.0018, len(nodes) - 1)
    pairs = zip(nodes[:-1], nodes[1:], radius, strict=True)
    return tuple(Stem(vector(a), vector(b), float(r), BARK) for a, b, r in pairs)


def grow_leaf(index: int, count: int, random: np.random.Generator) -> tuple[Leaf, Stem]:
    """Leaf number `index` of the branch with its stalk; leaves alternate above and below."""
    place = (index + 0.6) / count
    node = follow_branch(np.array(place))
    rise = 1.0 if index % 2 else -1.0
    out = np.array([random.normal(-0.1, 0.35), random.normal(-0.35, 0.3), rise])
    out /= np.linalg.norm(out)
    length, width = float(random.uniform(0.06, 0.09)), float(random.uniform(0.04, 0.06))
    foot = node + out * random.uniform(0.02, 0.035)
    back = np.array(SCANNER) - foot
    normal = back / np.linalg.norm(back) + random.normal(0.0, 0.45, 3)
    normal -= out * (normal @ out)
    centre = foot + out * length / 2
    leaf = Leaf(vector(centre), vector(out), vector(normal), length, width, water_leaf(random), 0.3)
    stalk = Stem(vector(node), vector(foot + 0.1 * length * out), 0.001, BARK)
    return shape_leaf(leaf, index % 3, random), stalk


def build_branch(seed: int, leaves: int = 19) -> Scene:
    """Leaves 0–5: the row at `TILTS`; then the leaves of the branch; behind them a wall.

    The wall is narrower and lower than the demo's field of view, so that some beams do
    not return.
    """
    random = np.random.default_rng(seed)
    row = tilted_row(np.array([2.6, 0.0, 1.462]), 0.09, TILTS)
    grown = [grow_leaf(index, leaves, random) for index in range(leaves)]
    rod = Stem((2.6, 0.27, 1.524), (2.6, -0.27, 1.524), 0.002, BARK)
    threads = [_hang(leaf, 1.524) for leaf in row]
    wall = Wall((5.5, 0.05, 1.57), (0.0, 0.62, 0.0), (0.0, 0.0, 0.45), MATT)
    return Scene(
        "demo branch",
        row + tuple(leaf for leaf, _ in grown),
        (*grow_axis(), *(stalk for _, stalk in grown), rod, *threads),
        (wall,),
    )


def _hang(leaf: Leaf, height: float) -> Stem:
    x, y, z = leaf.centre
    return Stem((x, y, height), (x, y, z + leaf.length / 2 - 0.002), 0.0008, BARK)
