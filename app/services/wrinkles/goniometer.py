"""A goniometer's table of angle and value, and the curve through it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.core.errors import BadInput
from app.core.fitting import FitResult, fit
from app.core.units import to_degrees, to_radians
from app.core.wrinkling.curve import KnownCurve, curve_of_fit
from app.core.wrinkling.offset import Scale
from app.services.table_notes import tell_radians
from app.services.tables import MISSING, read_table

ANGLE, VALUE = "angle", "value"
USUAL_MODEL: dict[Scale, str] = {"linear": "lambert-beckmann", "log": "polynomial-4"}
"""Balduzzi's polynomial for DN of a logarithmic amplifier; physics where it is linear."""
STEEPEST = float(to_radians(85.0))


def read_goniometer(
    path: Path, scale: Scale, model: str | None = None
) -> tuple[KnownCurve, FitResult]:
    """Fit the curve of a table with columns ``angle`` (degrees) and ``value``.

    Parameters
    ----------
    scale : {'linear', 'log'}
        Of the values, which are in the unit of the channel.
    model : str or None
        None: Lambert–Beckmann for linear values, the polynomial of fourth degree for DN.

    Raises
    ------
    BadInput
        The table cannot be read, holds angles outside 0 to 90°, angles in radians, or too few.
    """
    table = read_table(path, (ANGLE, VALUE))
    angle, value = table.numbers(ANGLE, MISSING), table.numbers(VALUE, MISSING)
    known = np.isfinite(angle) & np.isfinite(value)
    angle, value = angle[known], value[known]
    if not len(angle):
        raise BadInput(f"{table.name} holds no row with an angle and a value.")
    if (angle < 0.0).any() or (angle > 90.0).any():
        raise BadInput(
            f"{table.name} holds angles from {angle.min():g} to {angle.max():g}; those of "
            "incidence lie within 0° to 90°.",
        )
    for note in tell_radians(ANGLE, angle):
        raise BadInput(note, "Give degrees.")
    radians = np.minimum(to_radians(angle), np.pi / 2 - 1e-9)
    result = fit(model or USUAL_MODEL[scale], radians, value)
    first, last = (float(to_degrees(end)) for end in result.angle_range)
    origin = f"{path.name}, {len(angle)} angles of {first:g}° to {last:g}°, {result.model}"
    return curve_of_fit(result, scale, origin), result
