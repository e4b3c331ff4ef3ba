"""Intensity against incidence angle, made small enough to draw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.services.lab.bins import AngleBins, average
from app.services.lab.gather import Measured

ANGLE_CELLS, VALUE_CELLS = 180, 120
WIDEST = 90.0
STEP = 5.0
NONE, NO_ROWS = np.empty(0), np.empty(0, np.int64)
NOTHING = Measured(NONE, NONE, NO_ROWS, NO_ROWS)
NO_MEANS = AngleBins(NONE, NONE, NONE, NONE, NO_ROWS)


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Small rectangles of angle and value, (rows, columns) of them, in which points are counted.

    Angles reach from 0° to 90°, values from `low` to `high`.
    """

    low: float
    high: float

    @property
    def angles(self) -> Floats:
        """Edges of the columns, degrees."""
        return np.linspace(0.0, WIDEST, ANGLE_CELLS + 1)

    @property
    def values(self) -> Floats:
        """Edges of the rows."""
        return np.linspace(self.low, self.high, VALUE_CELLS + 1)

    def count(self, angle: Floats, value: Floats) -> AnyArray:
        """How many points fall into each cell; those beyond the borders into none."""
        with np.errstate(invalid="ignore", over="ignore"):
            row = (value - self.low) * (VALUE_CELLS / (self.high - self.low))
            column = angle * (ANGLE_CELLS / WIDEST)
        # The upper borders belong to the last cells.
        inside = (row >= 0) & (row <= VALUE_CELLS) & (column >= 0) & (column <= ANGLE_CELLS)
        rows = np.minimum(row[inside].astype(np.int64), VALUE_CELLS - 1)
        columns = np.minimum(column[inside].astype(np.int64), ANGLE_CELLS - 1)
        found = np.bincount(rows * ANGLE_CELLS + columns, minlength=VALUE_CELLS * ANGLE_CELLS)
        return found.reshape(VALUE_CELLS, ANGLE_CELLS)


@dataclass(frozen=True, slots=True, eq=False)
class AngularPoints:
    """What a plot of intensity against angle shows.

    Attributes
    ----------
    measured : Measured
        The points that have both.
    bottom, top : float
        Intensities that all but 0.2 % of the points lie between: the height of the plot. Zero
        is part of it unless all are negative (dB).
    density : (rows, columns) counts in `cells`, or None
        Where the points are too many to draw.
    cells : Cells
    means : AngleBins
        Means per step of the angle, as a fit to means sees them.
    reach : (float, float)
        Smallest and largest angle, degrees; NaN without points.
    """

    measured: Measured = NOTHING
    bottom: float = 0.0
    top: float = 1.0
    density: AnyArray | None = None
    cells: Cells = Cells(0.0, 1.0)
    means: AngleBins = NO_MEANS
    reach: tuple[float, float] = (np.nan, np.nan)

    @property
    def angle(self) -> Floats:
        """Angles, degrees."""
        return self.measured.angle

    @property
    def value(self) -> Floats:
        """Intensities."""
        return self.measured.value

    @property
    def count(self) -> int:
        """Points with both an angle and an intensity."""
        return len(self.measured)

    @property
    def dots(self) -> tuple[Floats, Floats] | None:
        """The points themselves, when they are few enough to draw."""
        return (self.angle, self.value) if self.count and self.density is None else None


NO_POINTS = AngularPoints()


def reduce_points(measured: Measured, most_dots: int, width: float = STEP) -> AngularPoints:
    """Make points ready to draw: up to `most_dots` as they are, more of them as a density.

    Parameters
    ----------
    measured : Measured
    most_dots : int
    width : float
        Of the steps of the means, degrees.
    """
    if len(measured) == 0:
        return NO_POINTS
    angle, value = measured.angle, measured.value
    low, top = (float(q) for q in np.quantile(value, (0.001, 0.999)))
    bottom = min(low, 0.0) if top > 0.0 else low
    cells = Cells(bottom, top + 0.05 * (top - bottom) if top > bottom else bottom + 1.0)
    return AngularPoints(
        measured=measured,
        bottom=bottom,
        top=top,
        density=None if len(angle) <= most_dots else cells.count(angle, value),
        cells=cells,
        means=average(angle, value, width),
        reach=(float(angle.min()), float(angle.max())),
    )


def find_lit(points: AngularPoints, selected: Ints, size: int) -> Bools:
    """Which of the points are among the rows `selected` of a scan of `size` points."""
    mask = np.zeros(size, bool)
    mask[selected] = True
    lit: Bools = mask[points.measured.point]
    return lit
