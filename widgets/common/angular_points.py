"""Intensity against incidence angle, made small enough to draw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.progress import QUIET, Progress
from app.model.project import Project
from app.services.curves import BIN, STEEPEST, angles_and_values

ANGLE_CELLS, VALUE_CELLS = 180, 120


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """Mean and standard deviation per 5° step up to 80°; empty steps are left out."""

    angle: Floats
    value: Floats
    sd: Floats


@dataclass(frozen=True, slots=True, eq=False)
class AngularPoints:
    """What a plot of intensity against angle shows.

    Attributes
    ----------
    count : int
        Points with both an angle and an intensity.
    reach : (float, float)
        Smallest and largest angle, degrees; NaN without points.
    bottom, top : float
        Intensities that all but 0.2 % of the points lie between: the height of the plot. Zero
        is part of it unless all are negative (dB).
    dots : (angles in degrees, values) or None
        The points themselves, when they are few.
    density : (counts, angle edges, value edges) or None
        Their density, when they are many.
    means : Means
    """

    count: int
    reach: tuple[float, float]
    bottom: float
    top: float
    dots: tuple[Floats, Floats] | None
    density: tuple[AnyArray, Floats, Floats] | None
    means: Means


def gather_points(
    project: Project,
    scan: str,
    points: Ints | None,
    channel: str,
    most_dots: int,
    progress: Progress = QUIET,
) -> AngularPoints:
    """Read angle and intensity of points (None: all living ones) and reduce them."""
    angle, value = angles_and_values(project, scan, points, channel, progress)
    return reduce_points(angle, value, most_dots)


def reduce_points(angle: Floats, value: Floats, most_dots: int) -> AngularPoints:
    """Keep up to `most_dots` points as they are, turn more of them into a density."""
    if len(angle) == 0:
        none = np.empty(0)
        return AngularPoints(0, (np.nan, np.nan), 0.0, 1.0, None, None, Means(none, none, none))
    low, top = (float(q) for q in np.quantile(value, (0.001, 0.999)))
    bottom = min(low, 0.0) if top > 0.0 else low
    few = len(angle) <= most_dots
    return AngularPoints(
        count=len(angle),
        reach=(float(angle.min()), float(angle.max())),
        bottom=bottom,
        top=top,
        dots=(angle, value) if few else None,
        density=None if few else _count(angle, value, bottom, top),
        means=describe_steps(angle, value),
    )


def _count(angle: Floats, value: Floats, low: float, top: float) -> tuple[AnyArray, Floats, Floats]:
    high = top + 0.05 * (top - low) if top > low else low + 1.0
    counts, values, angles = np.histogram2d(
        value, angle, (VALUE_CELLS, ANGLE_CELLS), ((low, high), (0.0, 90.0))
    )
    return counts, angles, values


def describe_steps(angle: Floats, value: Floats, width: float = BIN) -> Means:
    """Mean and standard deviation per step of `width` degrees up to 80°."""
    inside = angle < STEEPEST
    step = (angle[inside] // width).astype(np.int64)
    count = np.bincount(step)
    filled = count > 0
    number = count[filled]
    mean_angle = np.bincount(step, angle[inside])[filled] / number
    mean = np.bincount(step, value[inside])[filled] / number
    # About the mean, not by the difference of squares, which loses digits.
    place = np.cumsum(filled) - 1
    square = np.bincount(step, (value[inside] - mean[place[step]]) ** 2)[filled]
    sd = np.sqrt(square / np.maximum(number - 1, 1))
    return Means(mean_angle, mean, sd)
