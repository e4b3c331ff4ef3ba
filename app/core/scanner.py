"""Does a grid of points fit spherical coordinates about a place? Then the scanner stood there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats

ENOUGH_POINTS = 100
SAMPLE = 50_000


@dataclass(frozen=True, slots=True)
class SphericalFit:
    """How well rows and columns follow elevation and azimuth about a place.

    `column_step` and `row_step` are radians; the residuals are the 95 % quantiles of the
    deviations, in steps.
    """

    column_step: float
    row_step: float
    column_residual: float
    row_residual: float

    @property
    def fits(self) -> bool:
        """Whether nearly all points lie within a cell of where the grid says."""
        return self.column_residual < 1.0 and self.row_residual < 1.0


def fit_spherical(
    xyz: Floats, row: AnyArray, column: AnyArray, origin: Floats
) -> SphericalFit | None:
    """Compare a grid with the azimuths and elevations seen from `origin`.

    Parameters
    ----------
    xyz : (n, 3) float64 array
        Points in the scanner's own orientation (z along its axis), metres.
    row, column : (n,) integer arrays
    origin : (3,) float64 array

    Returns
    -------
    SphericalFit or None
        None when there are too few points, rows or columns to tell.
    """
    rows = np.flatnonzero(np.isfinite(xyz).all(axis=1))
    if len(rows) < ENOUGH_POINTS:
        return None
    rows = rows[:: max(1, len(rows) // SAMPLE)]
    x, y, z = (xyz[rows] - origin).T
    reach = np.hypot(x, y)
    if not (reach > 0).all() or np.ptp(row[rows]) < 3 or np.ptp(column[rows]) < 3:
        return None
    azimuth = _unwrap(np.arctan2(y, x), column[rows])
    elevation = np.arctan2(z, reach)
    column_step, column_residual = _spread(column[rows], azimuth)
    row_step, row_residual = _spread(row[rows], elevation)
    return SphericalFit(column_step, row_step, column_residual, row_residual)


def _unwrap(azimuth: Floats, column: AnyArray) -> Floats:
    order = np.argsort(column, kind="stable")
    unwrapped = np.empty_like(azimuth)
    unwrapped[order] = np.unwrap(azimuth[order])
    return unwrapped


def _spread(index: AnyArray, angle: Floats) -> tuple[float, float]:
    """Step per cell, and how far angles stray from the median of their own row or column.

    Real scanners do not turn evenly, so a straight line through all cells is too strict:
    seen from the right place, though, each row has one elevation and each column one azimuth.
    """
    cells, inverse = np.unique(index, return_inverse=True)
    order = np.lexsort((angle, inverse))
    starts = np.searchsorted(inverse[order], np.arange(len(cells) + 1))
    middle = angle[order][(starts[:-1] + starts[1:]) // 2]
    steps = np.diff(middle) / np.diff(cells)
    step = float(np.median(steps))
    if step == 0.0:
        return 0.0, np.inf
    return step, float(np.quantile(np.abs(angle - middle[inverse]), 0.95) / abs(step))
