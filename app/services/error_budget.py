"""Why a reflectance is as unsure as it is: of a point, or of the mean of a leaf."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Ints
from app.core.progress import QUIET, Progress
from app.core.radiometry import chain as chains
from app.core.radiometry.budget import PARTS, mean_budget
from app.core.radiometry.marks import WORDS
from app.core.radiometry.profile import ChannelCalibration
from app.model.parameters import Parameters
from app.model.project import Project
from app.model.radiometry_fields import (
    MARK,
    find_calibration,
    is_power_known,
    power_of,
    pull_of,
    source_of,
)


@dataclass(frozen=True, slots=True)
class Explained:
    """A reflectance, of a point or as the mean of several, and what makes it unsure.

    Attributes
    ----------
    reflectance, sigma : float
        NaN where no point has one.
    parts : mapping of str to float
        σ by cause: noise, fit, panels, power, range. NaN where nobody told: a laser power that
        was not measured, a noise of ranges; `sigma` then is that of the others.
    n : int
        Points with a reflectance.
    marks : mapping of str to int
        How many points have none, and why.
    """

    reflectance: float
    sigma: float
    parts: Mapping[str, float]
    n: int
    marks: Mapping[str, int]


def explain_reflectance(
    project: Project, scan: str, channel: str, points: Ints, progress: Progress = QUIET
) -> Explained:
    """Mean reflectance of points (or of one), its σ, and the parts of it.

    Raises
    ------
    WrongUse
        The channel is not one of the profile in use.
    """
    state = project.state.scan(scan)
    calibration = find_calibration(state.parameters, channel)
    points = points[state.alive[points]]
    values = project.field(scan, channel, points, progress)
    marks = project.field(scan, channel + MARK, points).astype(np.int64)
    number = project.field(scan, source_of(calibration, state), points)
    distance = (
        project.field(scan, "range", points) if calibration.needs_range else np.ones(len(points))
    )
    power = power_of(state.parameters, calibration)
    budget = mean_budget(
        calibration, values, number, distance, power.value, power.sigma, pull_of(power)
    )
    unknown = {part: float("nan") for part in _find_untold(calibration, state.parameters)}
    known = values[np.isfinite(values)]
    counts = np.bincount(marks, minlength=len(WORDS))
    return Explained(
        float(np.mean(known)) if len(known) else float("nan"),
        float(budget.sigma[0]),
        {part: float(value[0]) for part, value in zip(PARTS, budget, strict=True)} | unknown,
        len(known),
        {word: int(n) for word, n in zip(WORDS[1:], counts[1:], strict=True) if n},
    )


def _find_untold(calibration: ChannelCalibration, parameters: Parameters) -> list[str]:
    """Parts of a budget that are not zero but unknown."""
    power = [] if is_power_known(parameters, calibration) else ["power"]
    ranged = chains.needs_range(calibration.steps) and calibration.range_sigma == 0.0
    return [*power, "range"] if ranged else power
