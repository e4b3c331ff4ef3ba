"""Inverse range in windows that grow on flat surfaces and shrink at bends and edges.

Undisturbed windows come in three widths; the widest is taken whose slopes agree with those of
all narrower ones (Lepski 1991, On a problem of adaptive estimation in Gaussian white noise).
Where windows side by side tell of wrinkles, there is only the narrowest.
A point beside a jump takes the undisturbed half or quarter of a window that foretells its own
range best, instead of one with parts of two surfaces and the mixed pixels between. Where there
is none, or where it is no plane, cells within a gate are weighted by their residuals
(see `app.core.normals.robust`).
"""

from __future__ import annotations

import numpy as np

from app.core.normals.robust import CALM, CUT, LEAST_CUT
from app.core.normals.rules import JUMP, LARGEST, LEAST, SLOPE, Rules

WIDTHS = (1.0, 1.5, 2.0)
"""Half-widths of undisturbed windows, in radii."""
AGREE = 1.5
"""Standard errors by which slopes may differ; less costs width where nothing bends."""
EDGE = 1.5
"""Width of windows at edges, in radii: half of their cells are missing."""
AWAY = 3
CALM_BESIDE = 2.0
BENT = 2.0
WRINKLED = 0.03
"""Slopes are relative to the range: its root is 10°."""
PASSES = 3


def make_rules(radius: float, noise: float) -> Rules:
    """Rules of the windows for a radius and a noise of the range, metres.

    The factors were chosen on one simulated scene and confirmed on others, two of them from
    another simulator.
    """
    return Rules(
        widths=radius * np.array(WIDTHS), agree=AGREE, beside=radius * EDGE, away=AWAY,
        careful=radius * EDGE, noise=noise, slope=SLOPE, jump=JUMP, wrinkled=WRINKLED, bent=BENT,
        calm_beside=CALM_BESIDE, calm=CALM, cut=CUT, least_cut=LEAST_CUT, passes=PASSES,
        least=LEAST, widest=radius * LARGEST,
    )  # fmt: skip
