"""The fixed window, with weights where more than noise lies in it.

After the gate on range, cells are weighted once by their residual (Tukey's biweight; Beaton,
Tukey 1974), so that mixed pixels beside an edge lose their say.
"""

from __future__ import annotations

from app.core.normals import window
from app.core.normals.rules import Rules

CALM = 0.7
"""Noise variances that a residual needs to have to be doubted; the measured noise holds the
structure of the surfaces too, and so is rather too large."""
CUT, LEAST_CUT = 3.0, 2.5
"""Residuals count for nothing beyond this many of their rms, or of the noise's σ."""


def make_rules(radius: float, noise: float) -> Rules:
    """Rules of the windows for a radius and a noise of the range, metres."""
    return window.make_rules(radius, noise)._replace(
        calm=CALM, cut=CUT, least_cut=LEAST_CUT, passes=1
    )
