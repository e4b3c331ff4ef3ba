"""Why a point has no reflectance."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.radiometry import chain as chains
from app.core.radiometry.profile import ChannelCalibration

GOOD, NO_SIGNAL, DARK, SATURATED, BEYOND_RANGE, BEYOND_RESPONSE, PARTIAL = range(7)
WORDS = (
    "good",
    "no signal",
    "dark",
    "saturated",
    "outside the calibrated ranges",
    "outside the response",
    "partial hit",
)


def reflect(
    calibration: ChannelCalibration,
    number: Floats,
    distance: Floats,
    power: float = 1.0,
    partial: AnyArray | None = None,
) -> tuple[Floats, AnyArray]:
    """Reflectance of each point, and why there is none.

    Parameters
    ----------
    calibration : ChannelCalibration
    number : (n,) array
        What the instrument gave.
    distance : (n,) array
        Metres; any value where no step depends on it.
    power : float
        Laser power of the scan.
    partial : (n,) bool array, optional
        Points to leave out because the beam lies on them in part.

    Returns
    -------
    reflectance : (n,) array
        NaN where the mark is not `GOOD`. Nothing is extrapolated.
    marks : (n,) uint8 array
        Indices of `WORDS`; the first cause that applies, in their order.
    """
    steps = chains.with_power(calibration.steps, power)
    reflectance = chains.invert(steps, number, calibration.hold(distance))
    marks = np.where(np.isnan(reflectance), BEYOND_RESPONSE, GOOD).astype(np.uint8)
    if partial is not None:
        marks[partial & (marks == GOOD)] = PARTIAL
    marks[~calibration.holds(distance)] = BEYOND_RANGE
    if calibration.saturated is not None:
        marks[number >= calibration.saturated] = SATURATED
    if calibration.dark is not None:
        marks[number <= calibration.dark] = DARK
    marks[~np.isfinite(number)] = NO_SIGNAL
    return np.where(marks == GOOD, reflectance, np.nan), marks
