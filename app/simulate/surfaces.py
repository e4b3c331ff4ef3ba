"""Leaves, stems and walls, as a scene is written down and as the tracer reads it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.model.scan import Vector
from app.simulate.detector import Material

SLAB_MARGIN = 1e-4
"""Metres: keeps a crossing at the very top of a leaf inside its slab."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """A height field over an egg-shaped outline.

    In the leaf's own plane (x along, y across, s = 2x / length) the outline is
    |y| ≤ width/2 · (1 − taper · s) · √(1 − s²): an ellipse of the same area for every taper.
    The height is a cylinder of radius 1/curvature plus a wave along times a wave across.

    Attributes
    ----------
    centre, along, normal : Vector
        Metres; directions need not be of unit length, `along` is made square to `normal`.
    length, width : float
        Metres.
    curvature : float
        1/m, signed; 0 is flat.
    bend_direction : float
        Radians from `along`: the direction in which the leaf curves.
    wrinkle_height : float
        Metres, half of crest to valley.
    wrinkle_lengths, wrinkle_phases : pair of float
        Metres and radians of the waves along and across.
    """

    centre: Vector
    along: Vector
    normal: Vector
    length: float
    width: float
    material: Material
    taper: float = 0.0
    curvature: float = 0.0
    bend_direction: float = 0.0
    wrinkle_height: float = 0.0
    wrinkle_lengths: tuple[float, float] = (0.03, 0.03)
    wrinkle_phases: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if abs(self.curvature) * self.radius() > 0.95:
            raise WrongUse(
                f"A leaf {self.length} m long cannot be bent to {self.curvature} per metre.",
                "Its radius of curvature must be larger than its half length.",
            )

    def frame(self) -> Floats:
        """Rows along, across, normal: (3, 3), orthonormal."""
        normal = np.asarray(self.normal, float)
        normal = normal / np.linalg.norm(normal)
        along = np.asarray(self.along, float)
        along = along - normal * (along @ normal)
        along /= np.linalg.norm(along)
        return np.vstack([along, np.cross(normal, along), normal])

    def radius(self) -> float:
        """Radius of a circle in the leaf's plane that holds its outline."""
        return float(np.hypot(self.length / 2, self.width / 2 * (1 + abs(self.taper))))

    def reach(self) -> float:
        """Radius of a sphere about the centre that holds the leaf."""
        return float(np.hypot(self.radius(), max(map(abs, self.slab()))))

    def slab(self) -> tuple[float, float]:
        """Lowest and highest height over the plane, with a margin."""
        edge = self.curvature * self.radius()
        bend = (1 - np.sqrt(1 - edge**2)) / self.curvature if self.curvature else 0.0
        reach = abs(self.wrinkle_height) + SLAB_MARGIN
        return min(bend, 0.0) - reach, max(bend, 0.0) + reach


@dataclass(frozen=True, slots=True)
class Stem:
    """A cylinder with round ends; metres."""

    start: Vector
    end: Vector
    radius: float
    material: Material


@dataclass(frozen=True, slots=True)
class Wall:
    """A plane rectangle, given by two half edges that are square to each other; metres.

    `label` is its `truth_leaf`: −1, unless it stands in for a leaf.
    """

    centre: Vector
    across: Vector
    up: Vector
    material: Material
    label: int = -1


@dataclass(frozen=True, slots=True)
class Scene:
    """Surfaces in world metres, and the wavelengths that their materials speak of."""

    name: str
    leaves: tuple[Leaf, ...] = ()
    stems: tuple[Stem, ...] = ()
    walls: tuple[Wall, ...] = ()
    wavelengths_nm: tuple[float, ...] = (1063.0, 1545.0)

    def labels(self) -> Floats:
        """`truth_leaf` of each surface: leaves, stems, walls."""
        ids = [*range(len(self.leaves)), *[-1] * len(self.stems), *(w.label for w in self.walls)]
        return np.array(ids, dtype=np.int32)

    def optics(self) -> Floats:
        """rho, k_d and m of each surface and channel, (surfaces, channels, 3)."""
        materials = [s.material for group in (self.leaves, self.stems, self.walls) for s in group]
        table = [[(g.rho, g.k_d, g.m) for g in material] for material in materials]
        return np.array(table, float).reshape(len(materials), len(self.wavelengths_nm), 3)

    def spheres(self) -> Floats:
        """Centre and radius of a sphere around each leaf and stem, (n, 4)."""
        around = [(*s.centre, s.reach()) for s in self.leaves]
        for stem in self.stems:
            start, end = np.array(stem.start), np.array(stem.end)
            reach = float(np.linalg.norm(end - start)) / 2 + stem.radius
            around.append((*((start + end) / 2), reach))
        return np.array(around, float).reshape(-1, 4)
