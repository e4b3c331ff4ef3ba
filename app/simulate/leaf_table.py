"""The truth about each leaf of a scene, by its number in `truth_leaf`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.units import to_degrees
from app.model.scan import Vector
from app.simulate.leaf_shapes import unit, vector
from app.simulate.material import Material
from app.simulate.surfaces import Leaf, Scene, Stem, Wall

CHUNK = 100
"""Leaves measured at a time: their nodes stay in the processor's cache."""
MOST_NODES, MOST_WAVES = 1_000_000, 200
"""Of leaves measured at a time, and of one leaf: what fine wrinkles may take of the memory.

So many nodes are 1e-4 close even over a thousand waves.
"""

Kind = Literal["flat", "bent", "wrinkled", "lobed", "needle"]


@dataclass(frozen=True, slots=True)
class LeafTruth:
    """One leaf as it is.

    Attributes
    ----------
    number : int
        Its `truth_leaf`.
    kind : {"flat", "bent", "wrinkled", "lobed", "needle"}
    area : float
        One side of the curved surface, m²; of a needle half of its whole surface.
    length, width : float
        Of the plane outline without lobes, of a needle with its round ends; metres.
    centre, normal : Vector
        World metres; the normal of the leaf's plane, facing the scanner; of a needle the one
        that faces the beam to its centre best.
    tilt_deg : float
        Angle of that normal against the beam to the centre.
    water : float
        Share of a fresh leaf's.
    rho : tuple of float
        Reflectance at ω = 0, one per channel.
    """

    number: int
    kind: Kind
    area: float
    length: float
    width: float
    centre: Vector
    normal: Vector
    tilt_deg: float
    water: float
    rho: tuple[float, ...]


def tabulate_leaves(scene: Scene, scanner: Vector = (0.0, 0.0, 0.0)) -> tuple[LeafTruth, ...]:
    """All leaves, needles and leaf-like walls of a scene, by number."""
    place = np.array(scanner, float)
    areas = measure_areas(scene.leaves)
    rows = [
        _describe_leaf(number, leaf, float(area), place)
        for number, (leaf, area) in enumerate(zip(scene.leaves, areas, strict=True))
    ]
    rows += [_describe_needle(stem, place) for stem in scene.stems if stem.label >= 0]
    rows += [_describe_plane(wall, place) for wall in scene.walls if wall.label >= 0]
    return tuple(sorted(rows, key=lambda row: row.number))


def measure_areas(leaves: Sequence[Leaf]) -> Floats:
    """One-sided areas, m²: ∫ √(1 + h_x² + h_y²) dx dy over the outlines, to better than 1e-4."""
    areas = [_measure(leaves[k : k + CHUNK]) for k in range(0, len(leaves), CHUNK)]
    return np.concatenate([*areas, np.empty(0)])


def name_kind(leaf: Leaf) -> Kind:
    """What kind of leaf it is; lobes tell most, then wrinkles, then a bend."""
    if leaf.lobes and leaf.lobe_depth:
        return "lobed"
    if leaf.wrinkle_height:
        return "wrinkled"
    return "bent" if leaf.curvature else "flat"


def _measure(leaves: Sequence[Leaf]) -> Floats:
    radii, angles = _count_nodes(leaves)
    if len(leaves) > 1 and len(leaves) * radii * angles > MOST_NODES:
        half = len(leaves) // 2
        return np.concatenate([_measure(leaves[:half]), _measure(leaves[half:])])
    column = {name: _column(leaves, name) for name in _NUMBERS}
    x, y, weight = _spread_nodes(column, radii, angles)
    u, v = np.cos(column["bend_direction"]), np.sin(column["bend_direction"])
    s = column["curvature"] * (x * u + y * v)
    root = np.sqrt(1 - s * s)
    (kx, px), (ky, py) = (_waves(leaves, k) for k in (0, 1))
    height = column["wrinkle_height"]
    slope_x = s / root * u + height * kx * np.cos(kx * x + px) * np.sin(ky * y + py)
    slope_y = s / root * v + height * ky * np.sin(kx * x + px) * np.cos(ky * y + py)
    area: Floats = (weight * np.sqrt(1 + slope_x**2 + slope_y**2)).sum(axis=(1, 2))
    return area


_NUMBERS = (
    "length",
    "width",
    "taper",
    "curvature",
    "bend_direction",
    "wrinkle_height",
    "lobes",
    "lobe_depth",
)


def _column(leaves: Sequence[Leaf], name: str) -> Floats:
    return np.array([getattr(leaf, name) for leaf in leaves], float)[:, None, None]


def _waves(leaves: Sequence[Leaf], k: int) -> tuple[Floats, Floats]:
    length = np.array([leaf.wrinkle_lengths[k] for leaf in leaves])[:, None, None]
    phase = np.array([leaf.wrinkle_phases[k] for leaf in leaves])[:, None, None]
    return 2 * np.pi / length, phase


def _count_nodes(leaves: Sequence[Leaf]) -> tuple[int, int]:
    """Radii (Gauss–Legendre) and angles (periodic trapezoid) that keep the error below 1e-4.

    A steep wave's √(1 + slope²) has sharp valleys: it takes more nodes than a gentle one's.
    """
    wavy = [
        leaf.radius() / min(leaf.wrinkle_lengths) * (1 + leaf.wave_slope())
        for leaf in leaves
        if leaf.wrinkle_height
    ]
    waves = min(ceil(max(wavy, default=0.0)), MOST_WAVES)
    lobes = max(leaf.lobes for leaf in leaves)
    return 12 + 2 * waves, 48 + 12 * waves + 4 * lobes


def _spread_nodes(
    column: dict[str, Floats], radii: int, angles: int
) -> tuple[Floats, Floats, Floats]:
    """Places over each outline and the areas they stand for, (leaves, radii, angles).

    A node is q · f · (X, Y) of the egg's rim (X, Y) = (cos φ, (1 − taper cos φ) sin φ), of
    which the lobes leave the share f; q runs from 0 to 1, φ once around.
    """
    knots, weights = np.polynomial.legendre.leggauss(radii)
    q = ((knots + 1) / 2)[None, :, None]
    phi = (2 * np.pi * (np.arange(angles) + 0.5) / angles)[None, None, :]
    taper = column["taper"]
    rim_x, rim_y = np.cos(phi), (1 - taper * np.cos(phi)) * np.sin(phi)
    swept = rim_x * ((1 - taper * np.cos(phi)) * np.cos(phi) + taper * np.sin(phi) ** 2)
    swept = swept + rim_y * np.sin(phi)
    angle = np.arctan2(rim_y, rim_x)
    f = 1 - column["lobe_depth"] * (1 - np.cos(column["lobes"] * angle)) / 2
    half_length, half_width = column["length"] / 2, column["width"] / 2
    area = half_length * half_width * q * f**2 * swept
    weight = area * (weights / 2)[None, :, None] * 2 * np.pi / angles
    return q * f * rim_x * half_length, q * f * rim_y * half_width, weight


def _describe_leaf(number: int, leaf: Leaf, area: float, scanner: Floats) -> LeafTruth:
    return LeafTruth(
        number,
        name_kind(leaf),
        area,
        leaf.length,
        leaf.width,
        leaf.centre,
        *_face(np.array(leaf.centre), leaf.frame()[2], scanner),
        leaf.water,
        _rho(leaf.material),
    )


def _describe_needle(stem: Stem, scanner: Floats) -> LeafTruth:
    start, end = np.array(stem.start), np.array(stem.end)
    axis, centre = end - start, (start + end) / 2
    length = float(np.linalg.norm(axis))
    back = unit(scanner - centre)
    normal = back - axis * (axis @ back) / length**2
    if not normal.any():
        normal = back
    return LeafTruth(
        stem.label,
        "needle",
        float(np.pi * stem.radius * (length + 2 * stem.radius)),
        length + 2 * stem.radius,
        2 * stem.radius,
        vector(centre),
        *_face(centre, unit(normal), scanner),
        1.0,
        _rho(stem.material),
    )


def _describe_plane(wall: Wall, scanner: Floats) -> LeafTruth:
    across, up = np.array(wall.across), np.array(wall.up)
    length, width = 2 * float(np.linalg.norm(up)), 2 * float(np.linalg.norm(across))
    centre, normal = np.array(wall.centre), unit(np.cross(across, up))
    return LeafTruth(
        wall.label,
        "flat",
        length * width,
        length,
        width,
        wall.centre,
        *_face(centre, normal, scanner),
        1.0,
        _rho(wall.material),
    )


def _face(centre: Floats, normal: Floats, scanner: Floats) -> tuple[Vector, float]:
    """The normal turned towards the scanner, and its angle against the beam, degrees."""
    back = scanner - centre
    if normal @ back < 0:
        normal = -normal
    sine = float(np.linalg.norm(np.cross(normal, back)))
    return vector(normal), float(to_degrees(np.arctan2(sine, normal @ back)))


def _rho(material: Material) -> tuple[float, ...]:
    return tuple(sheen.rho for sheen in material)
