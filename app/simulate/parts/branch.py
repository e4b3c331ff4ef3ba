"""The branch of the demo, with its row of leaves at known tilts."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.simulate.branch import grow_branch
from app.simulate.material import Material
from app.simulate.painting import AnyMaterial, brighten
from app.simulate.parts.part import Count, Part, Pieces, Surroundings


class BranchPart(Part, frozen=True, kw_only=True, tag="branch"):
    """A branch 2.4 to 3.4 m ahead of a scanner at (0, 0, 1.6); leaves 0 to 5 are the row.

    Attributes
    ----------
    leaves : int
        On the branch.
    material, bark : name, number or recipe
    water_scatter : float
        σ of the leaves' water.
    """

    leaves: Count = 19
    material: AnyMaterial = "leaf"
    bark: AnyMaterial = "bark"
    water_scatter: Annotated[float, Meta(ge=0, le=0.5)] = 0.15

    def build(self, surroundings: Surroundings) -> Pieces:
        mix = surroundings.mix(self.material)

        def draw(random: np.random.Generator) -> tuple[Material, float]:
            wet = float(np.clip(self.water_scatter * random.standard_normal(), -0.45, 0.45))
            return brighten(mix(1 + wet), 1 + 0.03 * float(random.uniform(-1, 1))), 1 + wet

        bark, leaf = surroundings.paint(self.bark), mix(1.0)
        return Pieces(*grow_branch(surroundings.random, self.leaves, draw, bark, leaf))

    def count_surfaces(self) -> int:
        return 2 * self.leaves + 36
