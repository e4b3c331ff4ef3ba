"""Why an angle from intensity is not to be trusted, and up to where it may be."""

from __future__ import annotations

from enum import IntFlag

import numpy as np

# Beyond 60° intensity says little about angle (Balduzzi 2011, section 4; science.md 5).
TRUSTED_TO = np.pi / 3


class Doubt(IntFlag):
    """Why an angle from intensity is not to be trusted."""

    NONE = 0
    OUTSIDE = 1
    BEYOND = 2
    FLAT = 4
    AMBIGUOUS = 8
    SATURATED = 16
    PARTIAL = 32
    MISSING = 64
    GHOST = 128
