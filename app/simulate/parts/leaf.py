"""One leaf, told in full."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.units import to_radians
from app.model.scan import Vector
from app.simulate.leaf_shapes import tilted_normal, vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.foliage import Drying
from app.simulate.parts.part import LeafSize, Pieces, Placed, Point, Surroundings, Tilt, Turn
from app.simulate.spectra import WETTEST
from app.simulate.surfaces import SHORTEST_WAVE, Leaf

Wave = Annotated[float, Meta(ge=SHORTEST_WAVE, le=10)]
"""Metres; the tracer would step over shorter waves."""


class LeafPart(Placed, frozen=True, kw_only=True, tag="leaf"):
    """A leaf, tip down unless it is rolled; flat, bent, wrinkled or lobed by its numbers.

    Attributes
    ----------
    tilt_deg : float
        Angle against the beam, turned about the vertical.
    normal : point, optional
        Its normal in world axes, instead of `tilt_deg`.
    roll_deg : float
        Turn about the normal, anticlockwise as the scanner sees it.
    curvature, taper, lobes, lobe_depth, wrinkle_height, wrinkle_lengths :
        See `app.simulate.surfaces.Leaf`.
    bend_direction_deg, wrinkle_phases_deg : float, pair of float
    water : float
        Share of a fresh leaf's water when it was cut.
    drying : Drying
    """

    tilt_deg: Tilt = 0.0
    normal: Point | None = None
    roll_deg: Turn = 0.0
    length: LeafSize = 0.075
    width: LeafSize = 0.05
    taper: Annotated[float, Meta(ge=-0.9, le=0.9)] = 0.3
    curvature: Annotated[float, Meta(ge=-1000, le=1000)] = 0.0
    bend_direction_deg: Turn = 0.0
    wrinkle_height: Annotated[float, Meta(ge=-0.1, le=0.1)] = 0.0
    wrinkle_lengths: tuple[Wave, Wave] = (0.03, 0.03)
    wrinkle_phases_deg: tuple[Turn, Turn] = (0.0, 0.0)
    lobes: Annotated[int, Meta(ge=0, le=50)] = 0
    lobe_depth: Annotated[float, Meta(ge=0, le=0.95)] = 0.0
    material: AnyMaterial = "leaf"
    water: Annotated[float, Meta(ge=0, le=WETTEST)] = 1.0
    drying: Drying = Drying(scatter=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.normal is not None and (self.tilt_deg or not any(self.normal)):
            raise ValueError("`normal` stands instead of `tilt_deg` and is not zero")

    def build(self, surroundings: Surroundings) -> Pieces:
        centre = self.place(surroundings.scanner)
        normal, along = self._stand(surroundings.scanner)
        water = self.water * self.drying.water(surroundings.hours, surroundings.random)
        phases = to_radians(np.array(self.wrinkle_phases_deg))
        leaf = Leaf(
            vector(centre),
            along,
            normal,
            self.length,
            self.width,
            surroundings.paint(self.material, water),
            self.taper,
            self.curvature,
            float(to_radians(self.bend_direction_deg)),
            self.wrinkle_height,
            self.wrinkle_lengths,
            (float(phases[0]), float(phases[1])),
            self.lobes,
            self.lobe_depth,
            water=water,
        )
        return Pieces((leaf,))

    def _stand(self, scanner: Vector) -> tuple[Vector, Vector]:
        """Normal and direction of the tip."""
        centre = self.place(scanner)
        normal = self.normal
        if normal is None:
            normal = tilted_normal(centre, np.array(scanner), float(to_radians(self.tilt_deg)))
        facing = np.array(normal) / np.linalg.norm(normal)
        down = np.array([0.0, 0.0, -1.0])
        if np.linalg.norm(np.cross(facing, down)) < 1e-6:
            down = np.array([1.0, 0.0, 0.0])
        down = down - facing * (down @ facing)
        roll = to_radians(self.roll_deg)
        along = np.cos(roll) * down + np.sin(roll) * np.cross(facing, down)
        return normal, vector(along)
