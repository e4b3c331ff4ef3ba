"""The ways to a leaf's plane that are compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput
from app.core.incidence import incidence_angle
from app.core.inverse_plane import inverse_range_plane
from app.core.planes import (
    LeafPlane,
    leaf_plane,
    regression_plane,
    robust_plane,
    total_least_squares_plane,
)
from app.core.units import to_degrees
from app.simulate.beam import Bundle

HERE = np.zeros(3)
"""Where the scanner is."""
NAN = float("nan")
Fit = Callable[[Floats, Floats], LeafPlane]


def _fit_inside(xyz: Floats, scanner: Floats) -> LeafPlane:
    """The beams of all scans here are those of an LS880."""
    away = float(np.linalg.norm(xyz.mean(axis=0) - scanner))
    width = 2 * Bundle().radius(away)
    return inverse_range_plane(xyz, scanner, rim=width / away)


METHODS: Mapping[str, Fit] = {
    "LSR": regression_plane,
    "LSR or robust": leaf_plane,
    "TLS": total_least_squares_plane,
    "robust": robust_plane,
    "inverse range": inverse_range_plane,
    "inverse range, no rim": _fit_inside,
}
"""'LSR or robust' is what the program uses; 'no rim' leaves out a beam's width at the outline."""


@dataclass(frozen=True, slots=True)
class Angle:
    """What a method says of one leaf, degrees; NaN where it refuses, or knows no σ."""

    estimated: float
    true: float
    sigma: float

    @property
    def error(self) -> float:
        """Estimated − true."""
        return self.estimated - self.true


def measure_angle(method: str, xyz: Floats, normal: Floats) -> Angle:
    """Angle by a method, and that of the true normal for the beam to the same point."""
    try:
        plane = METHODS[method](xyz, HERE)
    except BadInput:
        return Angle(NAN, NAN, NAN)
    return Angle(
        float(to_degrees(plane.incidence)),
        angle_at(plane.point, normal),
        float(to_degrees(plane.sigma)),
    )


def angle_at(place: Floats, normal: Floats) -> float:
    """Angle at which the beam to a place meets a plane, degrees."""
    return float(to_degrees(incidence_angle(place[None], normal[None], HERE)[0]))
