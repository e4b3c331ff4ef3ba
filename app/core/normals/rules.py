"""How windows on the range image are chosen, and what all estimators take for granted."""

from __future__ import annotations

import math
from typing import NamedTuple

from app.core.arrays import Floats

HALO = 24
"""Cells around a tile; a window reaches no farther to either side."""
REACH = HALO - 6
"""Cells that a window may reach to either side; one beside a cell reaches farther."""
SLOPE = math.tan(math.radians(80.0))
"""Steeper surfaces look like a jump from cell to cell."""
JUMP = 5.0
"""Standard deviations of the noise that neighbouring ranges may differ by besides."""
LEAST = 6
"""Cells that a fit with holes in it needs."""
LARGEST = 10.0
"""Radii that one cell may be wide: beyond, the scan is too coarse for this radius."""


class Rules(NamedTuple):
    """How windows are chosen; the kernels read it by name.

    Attributes
    ----------
    widths : (w,) metres
        Half-widths that an undisturbed window may take, rising.
    agree : float
        Standard errors by which a wider window may differ from a narrower one.
    beside, careful : float
        Metres: width of a window beside a jump, half-width of one with jumps in it.
    away : int
        Cells that a window beside a jump may lie from the cell; 0: there is none.
    noise : float
        Metres: σ of the range.
    slope : float
        Tangent of the steepest surface that is no jump.
    jump : float
        σ that neighbours may differ by.
    wrinkled : float
        Squared change of the change of slope, from window to window side by side, from which
        on the surface is wrinkled: windows then have the least width, and none lies beside.
    bent : float
        Variances by noise that the bend of the surface may add to a window that lies half
        beside: beyond, windows at edges have the least width, and none lies beside.
    calm_beside, calm : float
        Noise variances up to which a residual is noise alone, beside a jump and over one.
    cut, least_cut : float
        Residuals beyond this many of their rms, or of σ, count for nothing.
    passes : int
        Of the fit with weights; 0: all cells within the gate count alike.
    least : int
        Cells that a fit needs.
    widest : float
        Metres: a window that must be wider is none.
    """

    widths: Floats
    agree: float
    beside: float
    away: int
    careful: float
    noise: float
    slope: float
    jump: float
    wrinkled: float
    bent: float
    calm_beside: float
    calm: float
    cut: float
    least_cut: float
    passes: int
    least: int
    widest: float
