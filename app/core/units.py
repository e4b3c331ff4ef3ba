"""The only place where degrees and millimetres meet radians and metres; numbers to read."""

from __future__ import annotations

from typing import Any

import numpy as np

MM_PER_M = 1000.0
DEG_PER_RAD = 180.0 / np.pi


def to_degrees(radians: Any) -> Any:
    """Radians to degrees; scalars and arrays."""
    return np.rad2deg(radians)


def to_radians(degrees: Any) -> Any:
    """Degrees to radians; scalars and arrays."""
    return np.deg2rad(degrees)


def to_mm(metres: Any) -> Any:
    """Metres to millimetres; scalars and arrays."""
    return metres * MM_PER_M


def group_digits(count: int) -> str:
    """A whole number with thousands apart by narrow spaces that do not break."""
    return f"{count:,}".replace(",", "\u202f")


def count_points(count: int) -> str:
    """``1 point``, ``2 501 points``."""
    return f"{group_digits(count)} point{'' if count == 1 else 's'}"
