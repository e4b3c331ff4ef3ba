"""Leaves, stems and walls, as a scene is written down and as the tracer reads it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import WrongUse
from app.model.scan import Vector
from app.simulate.material import Material

SLAB_MARGIN = 1e-4
"""Metres: keeps a crossing at the very top of a leaf inside its slab."""
MOST_BENT = 0.95
"""Largest curvature · radius of a leaf: nearer to 1 its rim would stand upright."""
SHORTEST_WAVE, STEEPEST_WAVE = 0.005, 3.0
"""Metres, and a slope: the tracer would step over shorter or steeper wrinkles."""


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
    lobes, lobe_depth : int, float
        The outline shrinks towards the centre by the share `lobe_depth` between lobes, by
        f(θ) = 1 − depth · (1 − cos(lobes · θ)) / 2 with θ = atan2(2y / width, 2x / length): a
        place (x, y) is inside when (x / f, y / f) is inside the egg. 0 lobes: none.
    sway, sway_rate, sway_phase : Vector, float, float
        Wind: at column c of the scan the leaf is displaced by sway · sin(rate · c + phase);
        metres and radians.
    water : float
        Its water as a share of a fresh leaf's; a fact for the truth table.
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
    lobes: int = 0
    lobe_depth: float = 0.0
    sway: Vector = (0.0, 0.0, 0.0)
    sway_rate: float = 0.0
    sway_phase: float = 0.0
    water: float = 1.0

    def __post_init__(self) -> None:
        if abs(self.curvature) * self.radius() > MOST_BENT:
            raise WrongUse(
                f"A leaf {self.length:g} m long and {self.width:g} m wide cannot be bent to "
                f"{self.curvature:g} per metre.",
                f"A circle about its outline, taper included, has a radius of {self.radius():.3g} "
                f"m, so that about {MOST_BENT / self.radius():.3g} per metre are the most.",
            )
        if self.wrinkle_height and min(self.wrinkle_lengths) < SHORTEST_WAVE:
            raise WrongUse(
                f"A leaf cannot have wrinkles {min(self.wrinkle_lengths):g} m long.",
                f"The shortest wave that the tracer can follow is {SHORTEST_WAVE:g} m.",
            )
        if self.wave_slope() > STEEPEST_WAVE:
            raise WrongUse(
                f"Wrinkles {abs(self.wrinkle_height):g} m high and {min(self.wrinkle_lengths):g} m "
                f"long are too steep: 2π · height / length is {self.wave_slope():.3g}.",
                f"Make them lower or longer: {STEEPEST_WAVE:g} is the most.",
            )

    def frame(self) -> Floats:
        """Rows along, across, normal: (3, 3), orthonormal."""
        frame: Floats = stack_frames((self,))[0]
        return frame

    def radius(self) -> float:
        """Radius of a circle in the leaf's plane that holds its outline."""
        return float(np.hypot(self.length / 2, self.width / 2 * (1 + abs(self.taper))))

    def reach(self) -> float:
        """Radius of a sphere about the centre that holds the leaf."""
        return float(np.hypot(self.radius(), max(map(abs, self.slab()))))

    def wave_slope(self) -> float:
        """Upper bound of the slope of its wrinkles."""
        return float(2 * np.pi * abs(self.wrinkle_height) / min(self.wrinkle_lengths))

    def steepest(self) -> float:
        """Upper bound of the slope of its height over the plane."""
        edge = abs(self.curvature) * self.radius()
        return float(edge / np.sqrt(1 - edge**2)) + self.wave_slope()

    def slab(self) -> tuple[float, float]:
        """Lowest and highest height over the plane, with a margin."""
        edge = self.curvature * self.radius()
        bend = (1 - np.sqrt(1 - edge**2)) / self.curvature if self.curvature else 0.0
        reach = abs(self.wrinkle_height) + SLAB_MARGIN
        return min(bend, 0.0) - reach, max(bend, 0.0) + reach


def stack_frames(leaves: tuple[Leaf, ...]) -> Floats:
    """Frames of many leaves, (n, 3, 3): rows along, across, normal, orthonormal."""
    along = np.array([leaf.along for leaf in leaves], float).reshape(-1, 3)
    normal = np.array([leaf.normal for leaf in leaves], float).reshape(-1, 3)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    along = along - normal * (along * normal).sum(axis=1, keepdims=True)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)


@dataclass(frozen=True, slots=True)
class Stem:
    """A cylinder with round ends; metres. `label` is its `truth_leaf`: a needle is a leaf."""

    start: Vector
    end: Vector
    radius: float
    material: Material
    label: int = -1

    def __post_init__(self) -> None:
        if self.start == self.end:
            raise WrongUse(
                f"A stem cannot start and end at the same place, {self.start}.",
                "Move one end away from the other, a millionth of a metre for a ball.",
            )


@dataclass(frozen=True, slots=True)
class Wall:
    """A plane rectangle, given by two half edges that are square to each other; metres.

    `label` is its `truth_leaf`: −1, unless it stands in for a leaf. `name` says what it is:
    wall, ground, panel 50 % …
    """

    centre: Vector
    across: Vector
    up: Vector
    material: Material
    label: int = -1
    name: str = "wall"


@dataclass(frozen=True, slots=True)
class Scene:
    """Surfaces in world metres, and the wavelengths that their materials speak of.

    A surface's index runs over leaves, then stems, then walls; `truth_leaf` of a leaf is its
    place in `leaves`, of a stem or wall its `label`, −1 or a number beyond the leaves'.
    """

    name: str
    leaves: tuple[Leaf, ...] = ()
    stems: tuple[Stem, ...] = ()
    walls: tuple[Wall, ...] = ()
    wavelengths_nm: tuple[float, ...] = (1063.0, 1545.0)

    def labels(self) -> AnyArray:
        """`truth_leaf` of each surface, (surfaces,) int32."""
        others = [*(s.label for s in self.stems), *(w.label for w in self.walls)]
        return np.array([*range(len(self.leaves)), *others], dtype=np.int32)

    def materials(self) -> tuple[Material, ...]:
        """Material of each surface."""
        return tuple(s.material for group in (self.leaves, self.stems, self.walls) for s in group)
