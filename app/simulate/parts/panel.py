"""A reference panel of known reflectance."""

from __future__ import annotations

from app.core.arrays import Floats
from app.simulate.leaf_shapes import vector
from app.simulate.painting import Rho
from app.simulate.parts.part import Metres, Pieces, Placed, Surroundings, Tilt
from app.simulate.surfaces import Wall


class PanelPart(Placed, frozen=True, kw_only=True, tag="panel"):
    """A matt square that faces the scanner.

    Attributes
    ----------
    rho : float
        Reflectance in every channel.
    size : float
        Side, metres.
    tilt_deg : float
        Turn about the vertical.
    """

    rho: Rho = 0.5
    size: Metres = 0.2
    tilt_deg: Tilt = 0.0

    def build(self, surroundings: Surroundings) -> Pieces:
        axes = self.face(surroundings.scanner, self.tilt_deg)
        centre = self.place(surroundings.scanner)
        return Pieces(walls=(make_panel(centre, axes, self.size, self.rho, surroundings),))


def make_panel(
    centre: Floats, axes: Floats, size: float, rho: float, surroundings: Surroundings
) -> Wall:
    """A square of one reflectance; rows of `axes` are left, up and towards the scanner."""
    across, up = axes[:2] * size / 2
    material = surroundings.paint(rho)
    return Wall(vector(centre), vector(across), vector(up), material, name=f"panel {100 * rho:g} %")
