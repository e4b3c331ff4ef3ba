"""Conifer needles side by side on black cloth (Kaasalainen 2018)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.units import to_radians
from app.simulate.leaf_shapes import vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import Count, Metres, Pieces, Placed, Surroundings, Tilt, Turn
from app.simulate.surfaces import Stem, Wall


class NeedleRowPart(Placed, frozen=True, kw_only=True, tag="needle_row"):
    """Parallel needles, a row on a board that turns about the vertical; each is a leaf.

    Attributes
    ----------
    count : int
    length, diameter, gap : float
        Metres; the gap is between two needles.
    angle_deg : float
        Turn of the board against the scanner.
    roll_deg : float
        Of the needles in the board: 0 upright, 90 level.
    material : name, number or recipe
    cloth : name, number or recipe
        What lies behind the needles.
    """

    count: Count = 20
    length: Metres = 0.05
    diameter: Annotated[float, Meta(gt=0, le=0.1)] = 0.0015
    gap: Annotated[float, Meta(ge=0, le=1)] = 0.0005
    angle_deg: Tilt = 0.0
    roll_deg: Turn = 0.0
    material: AnyMaterial = "needle"
    cloth: AnyMaterial = "black_cloth"

    def build(self, surroundings: Surroundings) -> Pieces:
        left, up, back = self.face(surroundings.scanner, self.angle_deg)
        roll = to_radians(self.roll_deg)
        along = np.cos(roll) * up + np.sin(roll) * left
        across = np.cos(roll) * left - np.sin(roll) * up
        middle = self.place(surroundings.scanner)
        places = ((self.count - 1) / 2 - np.arange(self.count)) * (self.diameter + self.gap)
        half = along * max(self.length - self.diameter, self.length / 100) / 2
        material = surroundings.paint(self.material)
        needles = tuple(
            Stem(vector(foot - half), vector(foot + half), self.diameter / 2, material, label)
            for label, foot in enumerate(middle + places[:, None] * across)
        )
        margin = 0.01
        cloth = Wall(
            vector(middle - back * self.diameter),
            vector(across * (float(np.ptp(places)) / 2 + self.diameter / 2 + margin)),
            vector(along * (self.length / 2 + margin)),
            surroundings.paint(self.cloth),
            name="cloth",
        )
        return Pieces(stems=needles, walls=(cloth,))

    def count_surfaces(self) -> int:
        return self.count + 1
