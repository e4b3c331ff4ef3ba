"""A wall, or the ground."""

from __future__ import annotations

from app.simulate.leaf_shapes import vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import Metres, Pieces, Placed, Surroundings, Tilt
from app.simulate.surfaces import Wall

BACKGROUND = ("wall", "ground")
"""Names of the surfaces that no field of view is fitted to."""


class WallPart(Placed, frozen=True, kw_only=True, tag="wall"):
    """An upright rectangle that faces the scanner, or a level one.

    Attributes
    ----------
    width, height : float
        Metres; the height of a level one is its depth, away from the scanner.
    tilt_deg : float
        Turn about the vertical.
    level : bool
        Lies flat: the ground.
    material : name, number or recipe, optional
        ``wall``, or ``ground`` for a level one.
    """

    width: Metres = 6.0
    height: Metres = 6.0
    tilt_deg: Tilt = 0.0
    level: bool = False
    material: AnyMaterial | None = None

    def build(self, surroundings: Surroundings) -> Pieces:
        left, up, back = self.face(surroundings.scanner, self.tilt_deg)
        name = BACKGROUND[self.level]
        wall = Wall(
            vector(self.place(surroundings.scanner)),
            vector(left * self.width / 2),
            vector((-back if self.level else up) * self.height / 2),
            surroundings.paint(name if self.material is None else self.material),
            name=name,
        )
        return Pieces(walls=(wall,))
