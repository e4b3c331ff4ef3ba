"""How wide the beam lies on a plane: an edge is moved through it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.footprint import footprint_axis
from app.core.units import to_radians
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import greys, send, silent
from app.simulate.beam import Bundle
from app.simulate.surfaces import Wall

GROUP = "footprint"
AWAY = 2.16
PRINTED = {0.0: 0.004056, 20.0: 0.197 * 0.0219, 65.0: 0.009596, 85.0: 0.04653}
"""Major axes of the LS880's beam at `AWAY`, metres, by angle: science 1.5."""
MANY = 1000


@dataclass(frozen=True, slots=True)
class Ends(Bundle):
    """The same beam with its axis and the two ends of its longest axis as sub-rays."""

    def subrays(self) -> Floats:
        """As `Bundle.subrays`."""
        return np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.25], [-1.0, 0.0, 0.25]])


def check_footprint(quick: bool) -> list[Check]:
    """The two places of an edge at which the beam begins and ceases to be on the wall."""
    steps = 40 if quick else 60
    angles, printed = to_radians(np.array(list(PRINTED))), list(PRINTED.values())
    beam = Ends()
    closed = footprint_axis(AWAY, angles, beam.exit_diameter / 2, beam.half_divergence)
    exact, spiral = (
        [_measure_axis(bundle, angle, steps) for angle in PRINTED]
        for bundle in (beam, Bundle(rays=MANY))
    )
    what = "major axis at 0, 20, 65, 85°:"
    return [
        compare(GROUP, f"{what} closed form, rays at its ends", closed, exact, 1e-7, relative=True),
        compare(GROUP, f"{what} as printed, rays at its ends", printed, exact, 1e-3, relative=True),
        # No seed of the spiral lies at the very end of an axis.
        compare(GROUP, f"{what} as printed, {MANY} rays", printed, spiral, 0.02, relative=True),
    ]


def _measure_axis(bundle: Bundle, incidence_deg: float, steps: int) -> float:
    """Distance along the plane between the edge's first and last touch of the beam."""
    low = _find_edge(bundle, incidence_deg, 1 - 1e-6, steps)
    high = _find_edge(bundle, incidence_deg, 1e-6, steps)
    return high - low


def _find_edge(bundle: Bundle, incidence_deg: float, share: float, steps: int) -> float:
    """Edge, metres along the plane from the beam's axis, beyond which less than `share` hits."""
    low, high = -0.2, 0.2
    for _ in range(steps):
        middle = (low + high) / 2
        if _share_beyond(bundle, middle, incidence_deg) >= share:
            low = middle
        else:
            high = middle
    return low


def _share_beyond(bundle: Bundle, edge: float, incidence_deg: float) -> float:
    tilt = to_radians(incidence_deg)
    slope = np.array([-np.sin(tilt), np.cos(tilt), 0.0])
    centre = np.array([AWAY, 0.0, 0.0]) + (edge + 1.0) * slope
    place = (float(centre[0]), float(centre[1]), 0.0)
    across = (float(slope[0]), float(slope[1]), 0.0)
    wall = Wall(place, across, (0.0, 0.0, 1.0), greys(0.5, 0.5))
    echo = send([wall], silent(bundle=bundle))
    return float(echo.share.sum()) if len(echo) else 0.0
