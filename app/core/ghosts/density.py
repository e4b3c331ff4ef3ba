"""A weaker ghost score without rows and columns: how few points lie around."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.ball import ENOUGH
from app.core.incidence import local_planes
from app.core.progress import QUIET, Progress

FULL_SURFACE = 0.6
"""Share of the median density that a surface at 53° still holds."""
LEAST_EXPECTED = 3.0
"""Points of a surface in the ball, below which one more or less says nothing."""
SAMPLE = 400


def score_by_density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress = QUIET
) -> Floats:
    """One minus the density in the ball, as a share of the median at equal range.

    NaN where the beams lie so far apart that even a surface would fill no ball.
    """
    # The median must not depend on which points are asked for.
    sample = np.unique(np.linspace(0, len(xyz) - 1, min(len(xyz), SAMPLE)).astype(np.int64))
    usual, _ = _measure_density(xyz, scanner, sample, radius, QUIET)
    density, count = _measure_density(xyz, scanner, points, radius, progress)
    if not np.isfinite(usual).any():
        return np.full(len(density), np.nan)
    full = FULL_SURFACE * np.nanmedian(usual)
    with np.errstate(invalid="ignore", divide="ignore"):
        expected = count * full / density
        score = np.clip(1.0 - density / full, 0.0, 1.0)
    unknown = (expected < LEAST_EXPECTED) & (count < ENOUGH)
    return np.where(unknown, np.nan, score)


def _measure_density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress
) -> tuple[Floats, AnyArray]:
    """Points per area of the ball, times the range squared (NaN without a range), and points."""
    planes = local_planes(xyz, scanner, points, radius, None, progress)
    asked = xyz if points is None else xyz[points]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        density: Floats = planes.count / planes.width**2 * ((asked - scanner) ** 2).sum(axis=1)
    return density, planes.count
