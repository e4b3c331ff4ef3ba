"""Inverse range regressed on the beam's directions, in a window of fixed angular width.

Along a plane n · P = h the inverse range of the beam u is 1 / r = (n · u) / h, linear in the
directions of a small window. The window does not depend on the noisy range, as a ball would,
which cuts the noise off along the beam and so turns the plane (nearest published idea:
Badino, Huber, Park, Kanade 2011, Fast and accurate computation of surface normals from range
images). Cells across a jump, told by a gate on their range, do not count.
"""

from __future__ import annotations

import numpy as np

from app.core.normals.rules import JUMP, LARGEST, LEAST, SLOPE, Rules


def make_rules(radius: float, noise: float) -> Rules:
    """Rules of the windows for a radius and a noise of the range, metres."""
    return Rules(
        widths=radius * np.ones(1), agree=np.inf, beside=radius, away=0, careful=radius,
        noise=noise, slope=SLOPE, jump=JUMP, wrinkled=np.inf, bent=np.inf, calm_beside=np.inf,
        calm=np.inf, cut=np.inf, least_cut=np.inf, passes=0, least=LEAST, widest=radius * LARGEST,
    )  # fmt: skip
