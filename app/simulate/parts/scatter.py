"""Leaves that float at random within a field of view, before whatever is behind."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.units import to_radians
from app.simulate.leaf_shapes import tilted_normal
from app.simulate.parts.foliage import Foliage
from app.simulate.parts.part import Count, Elevation, Part, Pieces, Surroundings, Turn, check_order
from app.simulate.surfaces import Leaf

Ranges = tuple[Annotated[float, Meta(gt=0, le=1000)], Annotated[float, Meta(gt=0, le=1000)]]


class ScatterPart(Part, frozen=True, kw_only=True, tag="scatter"):
    """Leaves at random ranges, directions and tilts; many hide one another.

    Attributes
    ----------
    count : int
    ranges : pair of float
        Nearest and farthest, metres.
    azimuth_deg, elevation_deg : pair of float
        The field in which their centres lie.
    steepest_deg : float
        Largest tilt against the beam.
    leaves : Foliage
    """

    count: Count = 12
    ranges: Ranges = (1.8, 4.2)
    azimuth_deg: tuple[Turn, Turn] = (-3.5, 3.5)
    elevation_deg: tuple[Elevation, Elevation] = (-2.5, 2.5)
    steepest_deg: Annotated[float, Meta(ge=0, lt=90)] = 70.0
    leaves: Foliage = Foliage()

    def __post_init__(self) -> None:
        check_order(
            ranges=self.ranges, azimuth_deg=self.azimuth_deg, elevation_deg=self.elevation_deg
        )

    def build(self, surroundings: Surroundings) -> Pieces:
        paint = surroundings.mix(self.leaves.material)

        def grow(index: int) -> Leaf:
            random, scanner = surroundings.random, np.array(surroundings.scanner)
            away = random.uniform(*self.ranges)
            side, rise = (
                to_radians(random.uniform(*field))
                for field in (self.azimuth_deg, self.elevation_deg)
            )
            flat = np.cos(rise)
            beam = np.array([flat * np.cos(side), flat * np.sin(side), np.sin(rise)])
            centre = scanner + away * beam
            tilt = to_radians(random.uniform(-self.steepest_deg, self.steepest_deg))
            normal = np.array(tilted_normal(centre, scanner, float(tilt)))
            place = (centre, random.normal(size=3), normal)
            return self.leaves.grow(index, place, surroundings, paint)

        return Pieces(tuple(grow(index) for index in range(self.count)))

    def count_surfaces(self) -> int:
        return self.count
