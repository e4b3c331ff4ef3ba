"""Beams of a scan grid, and the sub-rays that make one beam.

Sub-rays are straight: each leaves the exit disc at its own offset and spreads with the beam, so
that the footprint's radius at distance d is r0 + d · tan δ (science: Balduzzi 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import WrongUse
from app.core.units import to_radians

GOLDEN = float(np.pi * (3 - np.sqrt(5)))
"""Radians: the angle from seed to seed of a sunflower."""
SLACK = 5e-7
"""Half a millionth of a step: a field of 1.2° and a step of 0.1° are to reach both ends."""


@dataclass(frozen=True, slots=True)
class BeamGrid:
    """Rows of equal elevation, top to bottom, by columns of equal azimuth, left to right.

    Azimuth 0 looks along x and grows to the left, towards y. Radians.
    """

    top: float
    left: float
    step: float
    rows: int
    columns: int

    @property
    def elevation(self) -> Floats:
        """Elevation of each row, (rows,) radians."""
        return np.asarray(self.top - self.step * np.arange(self.rows), np.float64)

    @property
    def azimuth(self) -> Floats:
        """Azimuth of each column, (columns,) radians."""
        return np.asarray(self.left - self.step * np.arange(self.columns), np.float64)

    @property
    def directions(self) -> Floats:
        """Unit vectors of the beams, (rows, columns, 3), in scanner axes."""
        up, side = self.elevation[:, None], self.azimuth[None, :]
        flat = np.cos(up)
        return np.stack([flat * np.cos(side), flat * np.sin(side), np.sin(up) + 0 * side], axis=-1)

    def directions_of(self, cell: Ints) -> Floats:
        """Unit vectors of the beams of some cells (row · columns + column), (n, 3)."""
        up, side = self.elevation[cell // self.columns], self.azimuth[cell % self.columns]
        flat = np.cos(up)
        return np.stack([flat * np.cos(side), flat * np.sin(side), np.sin(up)], axis=-1)


@dataclass(frozen=True, slots=True)
class Bundle:
    """Shape of a beam: Gaussian, cut at its 1/e² radius.

    Attributes
    ----------
    exit_diameter : float
        Metres.
    half_divergence : float
        Radians, half angle.
    rays : int
        Sub-rays, one or more.
    """

    exit_diameter: float = 0.003
    half_divergence: float = float(np.deg2rad(0.014))
    rays: int = 37

    def radius(self, distance: float) -> float:
        """Radius of the beam at a distance, metres."""
        return float(self.exit_diameter / 2 + distance * np.tan(self.half_divergence))

    def subrays(self) -> Floats:
        """Offsets and shares, (rays, 3), from the middle outwards.

        Offsets are in units of the beam's radius, on a sunflower's spiral: each sub-ray stands
        for an equal area of the disc and carries the Gaussian's energy exp(-2 s²) there, and no
        straight edge meets many at once. The first is the beam's axis. The shares sum to 1.
        """
        number = np.arange(self.rays)
        radius = np.sqrt((number + 0.5) / self.rays)
        angle = GOLDEN * number
        share = np.exp(-2 * radius**2)
        radius[0] = 0.0
        places = (radius * np.cos(angle), radius * np.sin(angle))
        return np.column_stack([*places, share / share.sum()])


def angles_of(points: Floats, origin: Floats) -> tuple[Floats, Floats]:
    """Elevation and azimuth of points as seen from `origin`, radians."""
    x, y, z = (np.asarray(points, float) - origin).T
    return np.arctan2(z, np.hypot(x, y)), np.arctan2(y, x)


def grid_of_field(
    step_deg: float, azimuth_deg: tuple[float, float], elevation_deg: tuple[float, float]
) -> BeamGrid:
    """Grid that fills a field of view, given as (low, high) degrees.

    Both ends are in it where the step divides the field; of a full circle, whose ends are one
    direction, only the left one.

    Raises
    ------
    WrongUse
        The step is not a positive number, or is wider than the field.
    """
    width, tall = azimuth_deg[1] - azimuth_deg[0], elevation_deg[1] - elevation_deg[0]
    if not 0 < step_deg <= min(width, tall) * (1 + SLACK):
        raise WrongUse(
            f"A step of {step_deg}° does not fit a field of {width:.3g}° × {tall:.3g}°.",
            "Give a positive step that is smaller than the field.",
        )
    rows, columns = int(tall / step_deg + SLACK) + 1, int(width / step_deg + SLACK) + 1
    columns = min(columns, ceil(360 / step_deg - SLACK))
    return BeamGrid(
        float(to_radians(elevation_deg[1])),
        float(to_radians(azimuth_deg[1])),
        float(to_radians(step_deg)),
        rows,
        columns,
    )
