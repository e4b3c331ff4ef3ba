"""One round stem, twig or rod."""

from __future__ import annotations

from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import Metres, Part, Pieces, Point, Surroundings
from app.simulate.surfaces import Stem


class StemPart(Part, frozen=True, kw_only=True, tag="stem"):
    """A cylinder with round ends between two places in world metres."""

    start: Point
    end: Point
    radius: Metres = 0.01
    material: AnyMaterial = "bark"

    def __post_init__(self) -> None:
        if self.start == self.end:
            raise ValueError("`start` and `end` are the same place")

    def build(self, surroundings: Surroundings) -> Pieces:
        material = surroundings.paint(self.material)
        return Pieces(stems=(Stem(self.start, self.end, self.radius, material),))
