"""Shapes and attitudes of leaves, drawn at random or set."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.model.scan import Vector
from app.simulate.surfaces import Leaf

Shape = Literal["flat", "bent", "wrinkled", "lobed"]
IN_TURN: tuple[Shape, ...] = ("flat", "bent", "wrinkled")
NEAREST = 1e-6
"""Metres: what is nearer to the scanner has no direction."""


def vector(values: Floats) -> Vector:
    """Three numbers as a plain tuple."""
    return float(values[0]), float(values[1]), float(values[2])


def unit(values: Floats) -> Floats:
    """Vectors (…, 3) of length one."""
    length: Floats = np.linalg.norm(values, axis=-1, keepdims=True)
    return values / length


def tilted_normal(centre: Floats, origin: Floats, tilt: float) -> Vector:
    """Normal that meets the beam to `centre` at `tilt` radians, turned about the vertical.

    Straight above or below the scanner, where that turn would not tilt it, it leans towards y.

    Raises
    ------
    WrongUse
        The centre is where the scanner is.
    """
    check_apart(centre, origin)
    back = unit(origin - centre)
    side = np.cross([0.0, 0.0, 1.0], back)
    side = unit(side) if side.any() else np.array([0.0, 1.0, 0.0])
    return vector(np.cos(tilt) * back + np.sin(tilt) * side)


def check_apart(centre: Floats, scanner: Floats) -> None:
    """Raise `WrongUse` when a centre is where the scanner is."""
    if np.linalg.norm(centre - scanner) < NEAREST:
        raise WrongUse(
            f"Nothing can stand where the scanner is, at {vector(scanner)}.", "Move one of them."
        )


def shape_leaf(leaf: Leaf, shape: Shape, random: np.random.Generator) -> Leaf:
    """The leaf flat, or bent, wrinkled or lobed as a broad leaf may be."""
    if shape == "flat":
        return leaf
    if shape == "lobed":
        lobes = int(random.choice([3, 5, 7]))
        return replace(leaf, lobes=lobes, lobe_depth=float(random.uniform(0.25, 0.5)))
    curved = replace(
        leaf,
        curvature=float(random.choice([-1, 1]) * random.uniform(5.0, 14.0)),
        bend_direction=float(random.choice([0.0, np.pi / 2]) + random.normal(0, 0.2)),
    )
    if shape == "bent":
        return curved
    return replace(
        curved,
        curvature=curved.curvature / 4,
        wrinkle_height=float(random.uniform(0.0008, 0.002)),
        wrinkle_lengths=(float(random.uniform(0.02, 0.04)), float(random.uniform(0.02, 0.04))),
        wrinkle_phases=(float(random.uniform(0, 6.28)), float(random.uniform(0, 6.28))),
    )


def turn_about_vertical(vectors: Floats, angle: float) -> Floats:
    """Vectors (…, 3) turned by `angle` radians, left as seen from above."""
    c, s = np.cos(angle), np.sin(angle)
    turned: Floats = vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return turned
