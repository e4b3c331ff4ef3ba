"""A conifer shoot: a twig with needles on a spiral."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.units import to_radians
from app.simulate.beam import GOLDEN
from app.simulate.leaf_shapes import unit, vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import Count, Metres, Pieces, Placed, Surroundings, Tilt, Turn
from app.simulate.surfaces import Stem


class ShootPart(Placed, frozen=True, kw_only=True, tag="shoot"):
    """A straight twig across the beam, turned about the vertical; each needle is a leaf.

    Attributes
    ----------
    needles : int
    length : float
        Of the twig, metres.
    needle_length, diameter : float
        Of a needle, metres; spruce 0.015 and 0.0012, pine 0.05 and 0.0015.
    spread_deg : float
        Angle of the needles from the twig.
    scatter_deg : float
        σ of that angle.
    roll_deg : float
        Of the twig in the board that faces the scanner: 0 level with its tip to the right,
        90 upright.
    angle_deg : float
        Turn of that board about the vertical.
    material, bark : name, number or recipe
    """

    needles: Count = 150
    length: Metres = 0.12
    needle_length: Metres = 0.018
    diameter: Annotated[float, Meta(gt=0, le=0.1)] = 0.0012
    spread_deg: Annotated[float, Meta(ge=0, le=90)] = 50.0
    scatter_deg: Annotated[float, Meta(ge=0, le=45)] = 8.0
    roll_deg: Turn = 0.0
    angle_deg: Tilt = 0.0
    material: AnyMaterial = "needle"
    bark: AnyMaterial = "bark"

    def build(self, surroundings: Surroundings) -> Pieces:
        left, up, back = self.face(surroundings.scanner, self.angle_deg)
        roll = to_radians(self.roll_deg)
        axis = np.sin(roll) * up - np.cos(roll) * left
        side = np.cross(axis, back)
        base = self.place(surroundings.scanner) - axis * self.length / 2
        random, count = surroundings.random, self.needles
        turn = GOLDEN * np.arange(count) + random.normal(0, 0.15, count)
        lean = to_radians(self.spread_deg + self.scatter_deg * random.standard_normal(count))
        out = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * back
        ahead = unit(np.cos(lean)[:, None] * axis + np.sin(lean)[:, None] * out)
        feet = base + (np.linspace(0.02, 1.0, count) * self.length)[:, None] * axis
        tips = feet + ahead * self.needle_length * random.uniform(0.85, 1.1, (count, 1))
        needle, bark = surroundings.paint(self.material), surroundings.paint(self.bark)
        twig = Stem(vector(base), vector(base + axis * self.length), 1.2 * self.diameter, bark)
        return Pieces(
            stems=(
                twig,
                *(
                    Stem(vector(foot), vector(tip), self.diameter / 2, needle, label)
                    for label, (foot, tip) in enumerate(zip(feet, tips, strict=True))
                ),
            )
        )

    def count_surfaces(self) -> int:
        return self.needles + 1
