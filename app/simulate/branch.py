"""The demo: a branch with pear-like leaves, and a row of leaves at known tilts, before a wall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.model.scan import Vector
from app.simulate.leaf_shapes import IN_TURN, shape_leaf, tilted_normal, vector
from app.simulate.material import Material, glossy, matt
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

LEAF: Material = (glossy(0.48, 0.88, 0.22), glossy(0.27, 0.72, 0.30))
"""A fresh leaf at 1063 and 1545 nm."""
BARK: Material = (matt(0.42), matt(0.38))
MATT: Material = (matt(0.60), matt(0.50))
SCANNER: Vector = (0.0, 0.0, 1.6)
TILTS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
"""Degrees; the row for teaching."""

Draw = Callable[[np.random.Generator], tuple[Material, float]]
"""Draws a leaf's material and its water, as a share of a fresh leaf's."""


def water_leaf(random: np.random.Generator) -> tuple[Material, float]:
    """A leaf a little wetter or drier than `LEAF`: water darkens 1545 nm, hardly 1063 nm."""
    near, short = LEAF
    wet = float(np.clip(random.normal(0.0, 0.12), -0.3, 0.3))
    near = replace(near, rho=near.rho * (1 + 0.03 * float(random.uniform(-1, 1))))
    return (near, replace(short, rho=short.rho * (1 - wet))), 1 + wet


def tilted_row(
    centre: Floats,
    spacing: float,
    tilts_deg: tuple[float, ...],
    scanner: Vector = SCANNER,
    material: Material = LEAF,
) -> tuple[Leaf, ...]:
    """Flat leaves side by side, tips down, tilted by known angles against the beam."""
    origin = np.array(scanner)
    places = (len(tilts_deg) - 1) / 2 - np.arange(len(tilts_deg))
    row = []
    for place, tilt in zip(places, tilts_deg, strict=True):
        middle = centre + np.array([0.0, place * spacing, 0.0])
        normal = tilted_normal(middle, origin, np.deg2rad(tilt))
        row.append(Leaf(vector(middle), (0.0, 0.0, -1.0), normal, 0.075, 0.05, material, 0.3))
    return tuple(row)


def follow_branch(place: Floats) -> Floats:
    """Points of the main axis for places 0 (base, left and far) to 1 (tip, right and near)."""
    x = 3.35 - 0.95 * place
    y = 0.43 - 0.66 * place
    z = 1.545 + 0.195 * place - 0.17 * (place - 0.45) ** 2 + 0.012 * np.sin(9 * place)
    return np.stack([x, y, z], axis=-1)


def grow_axis(bark: Material) -> tuple[Stem, ...]:
    """The main axis, thinner towards its tip."""
    nodes = follow_branch(np.linspace(-0.15, 1.0, 24))
    radius = np.linspace(0.0075, 0.0018, len(nodes) - 1)
    pairs = zip(nodes[:-1], nodes[1:], radius, strict=True)
    return tuple(Stem(vector(a), vector(b), float(r), bark) for a, b, r in pairs)


def grow_leaf(
    index: int, count: int, random: np.random.Generator, draw: Draw, bark: Material
) -> tuple[Leaf, Stem]:
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
    material, water = draw(random)
    leaf = Leaf(
        vector(centre), vector(out), vector(normal), length, width, material, 0.3, water=water
    )
    stalk = Stem(vector(node), vector(foot + 0.1 * length * out), 0.001, bark)
    return shape_leaf(leaf, IN_TURN[index % 3], random), stalk


def grow_branch(
    random: np.random.Generator, leaves: int, draw: Draw, bark: Material, leaf: Material
) -> tuple[tuple[Leaf, ...], tuple[Stem, ...]]:
    """Leaves 0–5: the row at `TILTS`, hung on a rod; then the leaves of the branch."""
    row = tilted_row(np.array([2.6, 0.0, 1.462]), 0.09, TILTS, material=leaf)
    grown = [grow_leaf(index, leaves, random, draw, bark) for index in range(leaves)]
    rod = Stem((2.6, 0.27, 1.524), (2.6, -0.27, 1.524), 0.002, bark)
    threads = (_hang(leaf, 1.524, bark) for leaf in row)
    stalks = (stalk for _, stalk in grown)
    return (
        row + tuple(leaf for leaf, _ in grown),
        (*grow_axis(bark), *stalks, rod, *threads),
    )


def build_branch(seed: int, leaves: int = 19) -> Scene:
    """The branch and its row, and behind them a wall.

    The wall is narrower and lower than the demo's field of view, so that some beams do
    not return.
    """
    random = np.random.default_rng(seed)
    wall = Wall((5.5, 0.05, 1.57), (0.0, 0.62, 0.0), (0.0, 0.0, 0.45), MATT)
    return Scene("demo branch", *grow_branch(random, leaves, water_leaf, BARK, LEAF), (wall,))


def _hang(leaf: Leaf, height: float, bark: Material) -> Stem:
    x, y, z = leaf.centre
    return Stem((x, y, height), (x, y, z + leaf.length / 2 - 0.002), 0.0008, bark)
