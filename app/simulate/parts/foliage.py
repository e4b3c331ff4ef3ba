"""How the leaves of a part differ from one another, and how they dry."""

from __future__ import annotations

from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.simulate.leaf_shapes import IN_TURN, Shape, shape_leaf, vector
from app.simulate.painting import AnyMaterial, brighten
from app.simulate.parts.part import Interval, Paint, Share, Surroundings, check_order
from app.simulate.spectra import WETTEST
from app.simulate.surfaces import Leaf


class Drying(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Water of a cut leaf after h hours: w_end + (1 − w_end) · exp(−h / τ), as a share.

    Attributes
    ----------
    hours : float
        τ.
    final : float
        w_end.
    scatter : float
        Relative σ of both from leaf to leaf.
    """

    hours: Annotated[float, Meta(gt=0, le=10_000)] = 24.0
    final: Share = 0.1
    scatter: Annotated[float, Meta(ge=0, le=0.5)] = 0.2

    def water(self, hours: float, random: np.random.Generator) -> float:
        """Water left, as a share; draws the same numbers whatever the hours."""
        tau, final = np.exp(self.scatter * random.standard_normal(2)) * [self.hours, self.final]
        final = min(float(final), 1.0)
        return final + (1 - final) * float(np.exp(-hours / tau))


class Foliage(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What leaves are like, and how much they scatter.

    Attributes
    ----------
    material : name, number or recipe
    length, width : pair of float
        Shortest and longest, metres.
    shapes : tuple of {"flat", "bent", "wrinkled", "lobed"}
        Taken in turn.
    taper : float
        See `Leaf`.
    water_scatter : float
        σ of the water of fresh leaves; it darkens the water bands (about 6 % at 1545 nm for 0.1).
    rho_scatter : float
        Half width of a factor on the reflectance in all channels together.
    drying : Drying
    """

    material: AnyMaterial = "leaf"
    length: Interval = (0.06, 0.09)
    width: Interval = (0.04, 0.06)
    shapes: Annotated[tuple[Shape, ...], Meta(min_length=1, max_length=100)] = IN_TURN
    taper: Annotated[float, Meta(ge=-0.9, le=0.9)] = 0.3
    water_scatter: Annotated[float, Meta(ge=0, le=0.5)] = 0.1
    rho_scatter: Annotated[float, Meta(ge=0, le=0.5)] = 0.03
    drying: Drying = Drying()

    def __post_init__(self) -> None:
        check_order(length=self.length, width=self.width)

    def grow(
        self,
        index: int,
        place: tuple[Floats, Floats, Floats],
        surroundings: Surroundings,
        paint: Paint,
    ) -> Leaf:
        """Leaf number `index` of a part at a place: centre, along and normal, (3,) each.

        `paint` is `surroundings.mix(self.material)`, made once for all leaves of the part.
        """
        random = surroundings.random
        length, width = random.uniform(*self.length), random.uniform(*self.width)
        fresh = 1 + self.water_scatter * random.standard_normal()
        left = self.drying.water(surroundings.hours, random)
        # In steps of a hundredth, so that many leaves share a look-up of their spectrum.
        water = round(float(np.clip(fresh * left, 0.0, WETTEST)), 2)
        factor = 1 + self.rho_scatter * float(random.uniform(-1, 1))
        centre, along, normal = map(vector, place)
        leaf = Leaf(
            centre,
            along,
            normal,
            float(length),
            float(width),
            brighten(paint(water), factor),
            self.taper,
            water=water,
        )
        return shape_leaf(leaf, self.shapes[index % len(self.shapes)], random)
