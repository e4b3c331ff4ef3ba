"""Reference panels of several reflectances, side by side."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from app.simulate.painting import Rho
from app.simulate.parts.panel import make_panel
from app.simulate.parts.part import Metres, Pieces, Placed, Surroundings, Tilt


class PanelSetPart(Placed, frozen=True, kw_only=True, tag="panel_set"):
    """Matt squares in a row on one upright board, from left to right.

    Attributes
    ----------
    rhos : tuple of float
        Their reflectances, the same in every channel.
    size, gap : float
        Side of a panel and the gap between two, metres.
    tilt_deg : float
        Turn of the board about the vertical.
    """

    rhos: Annotated[tuple[Rho, ...], Meta(min_length=1, max_length=1000)] = (0.99, 0.5, 0.25, 0.12)
    size: Metres = 0.15
    gap: Annotated[float, Meta(ge=0, le=10)] = 0.03
    tilt_deg: Tilt = 0.0

    def build(self, surroundings: Surroundings) -> Pieces:
        axes = self.face(surroundings.scanner, self.tilt_deg)
        middle = self.place(surroundings.scanner)
        places = ((len(self.rhos) - 1) / 2 - np.arange(len(self.rhos))) * (self.size + self.gap)
        return Pieces(
            walls=tuple(
                make_panel(middle + place * axes[0], axes, self.size, rho, surroundings)
                for place, rho in zip(places, self.rhos, strict=True)
            )
        )

    def count_surfaces(self) -> int:
        return len(self.rhos)
