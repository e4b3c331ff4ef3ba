"""A leaf flattened on a stage that turns (Balduzzi 2011, section 2.2)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.core.units import to_radians
from app.model.scan import Vector
from app.simulate.leaf_shapes import unit, vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import LeafSize, Metres, Pieces, Placed, Surroundings, Tilt
from app.simulate.surfaces import Leaf, Stem, Wall

STRING = 0.0003
"""Radius of a black painted string, metres."""


class GoniometerPart(Placed, frozen=True, kw_only=True, tag="goniometer"):
    """A black plate that turns about its middle, and a leaf held on it by two black strings.

    Attributes
    ----------
    angle_deg : float
        Of the plate: its angle of incidence at the middle.
    axis : {"vertical", "horizontal"}
        About which it turns.
    length, width : float
        Of the leaf, metres; a half leaf of a pear tree unless said.
    size : float
        Side of the plate, metres.
    lift : float
        Of the leaf over the plate, metres.
    material, stage : name, number or recipe
    """

    angle_deg: Tilt = 0.0
    axis: Literal["vertical", "horizontal"] = "vertical"
    length: LeafSize = 0.0647
    width: LeafSize = 0.0219
    size: Metres = 0.12
    lift: Annotated[float, Meta(ge=0.0001, le=0.1)] = 0.001
    material: AnyMaterial = "leaf"
    stage: AnyMaterial = "black_cloth"

    def build(self, surroundings: Surroundings) -> Pieces:
        left, up, back = self._turn(surroundings.scanner)
        middle = self.place(surroundings.scanner)
        leaf = Leaf(
            vector(middle),
            vector(-up),
            vector(back),
            self.length,
            self.width,
            surroundings.paint(self.material),
        )
        black, half = surroundings.paint(self.stage), self.size / 2
        plate = Wall(
            vector(middle - back * self.lift),
            vector(left * half),
            vector(up * half),
            black,
            name="stage",
        )
        strings = tuple(
            Stem(vector(place - left * half), vector(place + left * half), STRING, black)
            for place in (middle + back * STRING + up * self.length * k for k in (-0.3, 0.3))
        )
        return Pieces((leaf,), strings, (plate,))

    def count_surfaces(self) -> int:
        return 4

    def _turn(self, scanner: Vector) -> Floats:
        """Axes of the plate: rows left, up and off its front."""
        left = self.face(scanner)[0]
        back = unit(np.array(scanner) - self.place(scanner))
        up = np.cross(left, back)
        c, s = np.cos(to_radians(self.angle_deg)), np.sin(to_radians(self.angle_deg))
        if self.axis == "vertical":
            return np.vstack([c * left + s * back, up, c * back - s * left])
        return np.vstack([left, c * up + s * back, c * back - s * up])
