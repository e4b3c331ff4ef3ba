"""Flat leaves side by side at known tilts, for teaching and for tests."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from app.simulate.branch import TILTS, tilted_row
from app.simulate.painting import AnyMaterial
from app.simulate.parts.part import Metres, Pieces, Placed, Surroundings, Tilt


class LeafRowPart(Placed, frozen=True, kw_only=True, tag="leaf_row"):
    """Leaves from left to right, each tilted by a known angle against its own beam.

    Attributes
    ----------
    tilts_deg : tuple of float
    spacing : float
        Between centres, metres.
    material : name, number or recipe
    """

    tilts_deg: Annotated[tuple[Tilt, ...], Meta(min_length=1, max_length=1000)] = TILTS
    spacing: Metres = 0.08
    material: AnyMaterial = "leaf"

    def build(self, surroundings: Surroundings) -> Pieces:
        scanner, material = surroundings.scanner, surroundings.paint(self.material)
        row = tilted_row(self.place(scanner), self.spacing, self.tilts_deg, scanner, material)
        return Pieces(row)

    def count_surfaces(self) -> int:
        return len(self.tilts_deg)
