"""A row of young pear trees (Balduzzi 2011, section 2.2 and figure 2)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.core.arrays import Floats
from app.simulate.leaf_shapes import unit, vector
from app.simulate.material import Material
from app.simulate.painting import AnyMaterial
from app.simulate.parts.foliage import Foliage
from app.simulate.parts.part import UP, Metres, Paint, Pieces, Placed, Surroundings, Tilt
from app.simulate.surfaces import Leaf, Stem

LOWEST, NODES = 0.2, 8
"""Share of a tree's height without leaves; pieces of its trunk."""


class PearRowPart(Placed, frozen=True, kw_only=True, tag="pear_row"):
    """Two-year-old trees: a thin trunk and leaves on short stalks all around it.

    The centre is the foot of the middle tree; give it as `centre`, or as `range` and `azimuth_deg`:
    it then stands `ground` below the scanner.

    Attributes
    ----------
    trees : int
    spacing, height : float
        Metres.
    leaves_per_tree : int
    tilt_deg : float
        Turn of the row about the vertical.
    ground : float
        Height of the ground in world metres, where no `centre` is given.
    leaves : Foliage
        6.5 cm long and twice 2.2 cm wide, curled, as the paper says.
    bark : name, number or recipe
    """

    trees: Annotated[int, Meta(ge=1, le=1000)] = 15
    spacing: Metres = 0.3
    height: Metres = 2.0
    leaves_per_tree: Annotated[int, Meta(ge=1, le=10_000)] = 60
    tilt_deg: Tilt = 0.0
    ground: float = 0.0
    leaves: Foliage = Foliage(
        length=(0.055, 0.075), width=(0.036, 0.051), shapes=("bent", "wrinkled", "bent", "flat")
    )
    bark: AnyMaterial = "bark"

    def build(self, surroundings: Surroundings) -> Pieces:
        foot = self.place(surroundings.scanner)
        if self.centre is None:
            foot[2] = self.ground
        left = self.face(surroundings.scanner, self.tilt_deg)[0]
        places = ((self.trees - 1) / 2 - np.arange(self.trees)) * self.spacing
        paint, bark = surroundings.mix(self.leaves.material), surroundings.paint(self.bark)
        leaves: list[Leaf] = []
        stems: list[Stem] = []
        for place in places:
            nodes = self._trunk(foot + place * left, surroundings.random)
            radii = np.linspace(0.012, 0.003, NODES)
            pairs = zip(nodes[:-1], nodes[1:], radii, strict=True)
            stems += [Stem(vector(a), vector(b), float(r), bark) for a, b, r in pairs]
            for index in range(self.leaves_per_tree):
                leaf, stalk = self._leaf(index, nodes, surroundings, (paint, bark))
                leaves.append(leaf)
                stems.append(stalk)
        return Pieces(tuple(leaves), tuple(stems))

    def count_surfaces(self) -> int:
        return self.trees * (2 * self.leaves_per_tree + NODES)

    def _trunk(self, foot: Floats, random: np.random.Generator) -> Floats:
        """A slightly crooked line upwards, (NODES + 1, 3)."""
        rise = np.linspace(0.0, 1.0, NODES + 1)[:, None]
        sway = np.cumsum(random.normal(0.0, 0.01, (NODES + 1, 3)), axis=0) * [1.0, 1.0, 0.0]
        height = self.height * float(random.uniform(0.9, 1.1))
        line: Floats = foot + rise * height * UP + sway
        return line

    def _leaf(
        self,
        index: int,
        nodes: Floats,
        surroundings: Surroundings,
        looks: tuple[Paint, Material],
    ) -> tuple[Leaf, Stem]:
        """A leaf that grows out and up, its face to the sky more than to the ground."""
        random = surroundings.random
        place = (LOWEST + (1 - LOWEST) * random.uniform()) * NODES
        step = min(int(place), NODES - 1)
        node = nodes[step] + (place - step) * (nodes[step + 1] - nodes[step])
        around = random.uniform(0.0, 2 * np.pi)
        out = np.array([np.cos(around), np.sin(around), random.normal(0.2, 0.35)])
        out = unit(out)
        foot = node + out * random.uniform(0.02, 0.12)
        normal = UP + random.normal(0.0, 0.6, 3)
        normal -= out * (normal @ out)
        length = float(np.mean(self.leaves.length))
        leaf = self.leaves.grow(
            index, (foot + out * length / 2, out, normal), surroundings, looks[0]
        )
        base = np.array(leaf.centre) - out * leaf.length / 2
        return leaf, Stem(vector(node), vector(base), 0.0008, looks[1])
