"""A weaker ghost score without rows and columns: how few points lie around."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.incidence import local_planes
from app.core.progress import QUIET, Progress

FULL_SURFACE = 0.6
"""Share of the median density that a surface at 53° still holds."""
SAMPLE = 400


def score_by_density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress = QUIET
) -> Floats:
    """One minus the density in the ball, as a share of the median at equal range."""
    # The median must not depend on which points are asked for.
    sample = np.unique(np.linspace(0, len(xyz) - 1, min(len(xyz), SAMPLE)).astype(np.int64))
    usual = _measure_density(xyz, scanner, sample, radius, QUIET)
    density = _measure_density(xyz, scanner, points, radius, progress)
    if not np.isfinite(usual).any():
        return np.full(len(density), np.nan)
    return np.clip(1.0 - density / (FULL_SURFACE * np.nanmedian(usual)), 0.0, 1.0)


def _measure_density(
    xyz: Floats, scanner: Floats, points: Ints | None, radius: float, progress: Progress
) -> Floats:
    """Points per area of the ball, times the range squared; NaN without a range."""
    planes = local_planes(xyz, scanner, points, radius, None, progress)
    asked = xyz if points is None else xyz[points]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        density: Floats = planes.count / planes.width**2 * ((asked - scanner) ** 2).sum(axis=1)
    return density
