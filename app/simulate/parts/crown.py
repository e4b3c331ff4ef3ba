"""A whole broadleaf crown: trunk, boughs, and ten thousand leaves."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.simulate.leaf_shapes import unit, vector
from app.simulate.painting import AnyMaterial
from app.simulate.parts.foliage import Foliage
from app.simulate.parts.part import UP, Count, Metres, Pieces, Placed, Surroundings
from app.simulate.surfaces import Stem


class CrownPart(Placed, frozen=True, kw_only=True, tag="crown"):
    """Leaves in the shell of an ellipsoid about the centre.

    Their normals lean to the sky and outwards, with scatter: between planophile and spherical.

    Attributes
    ----------
    count : int
        Leaves.
    radius, half_height : float
        Of the ellipsoid, metres.
    hollow : float
        Share of its radius without leaves.
    trunk : float
        Height of the trunk below the crown, metres.
    boughs : int
    leaves : Foliage
    bark : name, number or recipe
    """

    count: Count = 10_000
    radius: Metres = 2.0
    half_height: Metres = 2.2
    hollow: Annotated[float, Meta(ge=0, lt=1)] = 0.45
    trunk: Metres = 1.8
    boughs: Annotated[int, Meta(ge=0, le=1000)] = 40
    leaves: Foliage = Foliage()
    bark: AnyMaterial = "bark"

    def build(self, surroundings: Surroundings) -> Pieces:
        random, centre = surroundings.random, self.place(surroundings.scanner)
        axes = np.array([self.radius, self.radius, self.half_height])
        paint = surroundings.mix(self.leaves.material)
        out = unit(random.normal(size=(self.count, 3)))
        # The cube root spreads the leaves evenly over the shell's volume.
        away = np.cbrt(random.uniform(self.hollow**3, 1.0, self.count))
        places = centre + away[:, None] * out * axes
        normals = unit(out / axes) * 0.5 + UP * 0.6 + random.normal(0.0, 0.45, out.shape)
        along = out - 0.4 * UP + random.normal(0.0, 0.5, out.shape)
        rows = zip(places, along, normals, strict=True)
        leaves = tuple(
            self.leaves.grow(index, place, surroundings, paint) for index, place in enumerate(rows)
        )
        return Pieces(leaves, self._grow_wood(centre, axes, surroundings))

    def count_surfaces(self) -> int:
        return self.count + 2 * self.boughs + 2

    def _grow_wood(
        self, centre: Floats, axes: Floats, surroundings: Surroundings
    ) -> tuple[Stem, ...]:
        """A trunk to the middle of the crown, and boughs of two pieces that rise outwards."""
        random, bark = surroundings.random, surroundings.paint(self.bark)
        foot = centre - UP * (self.half_height + self.trunk)
        thick = 0.06 * self.radius
        stems = [
            Stem(vector(foot), vector(centre), thick, bark),
            Stem(vector(centre), vector(centre + 0.7 * self.half_height * UP), thick / 2, bark),
        ]
        for _ in range(self.boughs):
            start = centre + UP * self.half_height * random.uniform(-0.8, 0.6)
            out = unit(random.normal(size=3) * [1.0, 1.0, 0.5] + 0.3 * UP)
            end = centre + random.uniform(0.6, 0.95) * out * axes
            knee = (start + end) / 2 - 0.08 * self.radius * UP
            stems.append(Stem(vector(start), vector(knee), thick / 5, bark))
            stems.append(Stem(vector(knee), vector(end), thick / 10, bark))
        return tuple(stems)
