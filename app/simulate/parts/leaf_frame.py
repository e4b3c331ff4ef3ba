"""Leaves hung by thin black thread in a frame that turns (Hancock 2017, section II-B)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.core.units import to_radians
from app.simulate.leaf_shapes import vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.foliage import Foliage
from app.simulate.parts.part import Metres, Pieces, Placed, Surroundings, Turn
from app.simulate.surfaces import Leaf, Stem

THREAD, BAR = 0.0002, 0.006
"""Radii, metres."""


class LeafFramePart(Placed, frozen=True, kw_only=True, tag="leaf_frame"):
    """A square frame, turned as a whole about the vertical; its leaves dry with the hours.

    The leaves keep their places and shapes whatever the angle and the hour.

    Attributes
    ----------
    angle_deg : float
        The holder angle.
    across : float
        Side of the frame, metres.
    columns, rows : int
        Of leaves.
    lean_deg : float
        σ of a leaf's own angle against the frame, about both axes of the frame.
    leaves : Foliage
    thread : name, number or recipe
        Of threads and bars.
    """

    angle_deg: Turn = 0.0
    across: Metres = 0.42
    columns: Annotated[int, Meta(ge=1, le=100)] = 4
    rows: Annotated[int, Meta(ge=1, le=100)] = 3
    lean_deg: Annotated[float, Meta(ge=0, le=30)] = 5.0
    leaves: Foliage = Foliage(length=(0.07, 0.1), width=(0.035, 0.05), shapes=("flat",))
    thread: AnyMaterial = "black_cloth"

    def build(self, surroundings: Surroundings) -> Pieces:
        axes = self.face(surroundings.scanner, self.angle_deg)
        middle = self.place(surroundings.scanner)
        paint = surroundings.mix(self.leaves.material)
        black = surroundings.paint(self.thread)
        leaves, threads = [], []
        for index in range(self.columns * self.rows):
            row, column = divmod(index, self.columns)
            side = ((self.columns - 1) / 2 - column) * self.across / self.columns
            rise = ((self.rows - 1) / 2 - row) * self.across / self.rows
            lean = to_radians(self.lean_deg) * surroundings.random.standard_normal(2)
            place = _lean((middle + side * axes[0] + rise * axes[1], *axes), lean)
            leaf = self.leaves.grow(index, place, surroundings, paint)
            leaves.append(leaf)
            threads += self._hang(leaf, rise, axes)
        # A leaf that reaches from bar to bar hangs on no thread.
        stems = [Stem(vector(a), vector(b), THREAD, black) for a, b in threads if (a != b).any()]
        return Pieces(tuple(leaves), (*stems, *self._bars(middle, axes, surroundings)))

    def count_surfaces(self) -> int:
        return 3 * self.columns * self.rows + 4

    def _hang(self, leaf: Leaf, rise: float, axes: Floats) -> list[tuple[Floats, Floats]]:
        """Threads from the leaf's stalk and tip to the bars above and below."""
        tip = leaf.frame()[0] * leaf.length / 2
        top, bottom = np.array(leaf.centre) - tip, np.array(leaf.centre) + tip
        above = (self.across / 2 - rise - leaf.length / 2) * axes[1]
        below = (self.across / 2 + rise - leaf.length / 2) * axes[1]
        return [(top, top + above), (bottom, bottom - below)]

    def _bars(self, middle: Floats, axes: Floats, surroundings: Surroundings) -> list[Stem]:
        black, half = surroundings.paint(self.thread), self.across / 2 + BAR
        corners = [middle + half * (a * axes[0] + b * axes[1]) for a, b in _CORNERS]
        pairs = zip(corners, corners[1:] + corners[:1], strict=True)
        return [Stem(vector(a), vector(b), BAR, black) for a, b in pairs]


_CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


def _lean(
    place: tuple[Floats, Floats, Floats, Floats], lean: Floats
) -> tuple[Floats, Floats, Floats]:
    """Centre, along and normal of a leaf that hangs tip down and leans off the frame."""
    centre, left, up, back = place
    normal = back + np.tan(lean[0]) * left + np.tan(lean[1]) * up
    return centre, -up, normal
