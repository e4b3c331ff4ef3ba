"""Why a point has no corrected value, or one to be careful with."""

from __future__ import annotations

GOOD, NO_INTENSITY, NO_ANGLE, BEYOND_FITTED, SMALL_BRACKET, NEGATIVE, NO_CORRECTION = range(7)
WORDS = (
    "good",
    "no intensity",
    "no angle",
    "beyond the fitted angles",
    "bracket too small",
    "negative",
    "no correction for it",
)
