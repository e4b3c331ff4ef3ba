"""Points inside a lasso: all of them, or those that the viewer sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import WrongUse
from app.core.screen.lasso import lasso_mask
from app.core.screen.projection import Projected, View, project
from app.core.screen.visibility import visible_mask
from app.core.units import group_digits, to_mm

Mode = Literal["visible", "through"]

# A surface tilted by 68° against the view falls 2.5 m behind per metre, and the front of a
# 2-pixel square may lie 2 pixels aside: 5 pixels. 2 mm is the range noise of the scanners.
TOLERANCE_PIXELS = 5.0
SMALLEST_TOLERANCE = 0.002


@dataclass(frozen=True, slots=True, eq=False)
class LassoResult:
    """What a lasso caught.

    Attributes
    ----------
    indices : (m,) int64, ascending
        Rows of the selected points.
    hidden : int
        Points inside the lasso left out because others cover them.
    tolerance : float
        Depth tolerance that was used, in metres; zero when selecting through. Store it: a
        replay that gives it again finds the same points.
    mode : {'visible', 'through'}
    """

    indices: Ints
    hidden: int
    tolerance: float
    mode: Mode

    def describe(self) -> str:
        """The sentence for the status bar."""
        count = group_digits(len(self.indices))
        if self.mode == "through":
            return f"{count} selected, through everything"
        hidden = group_digits(self.hidden)
        return f"{count} selected, {hidden} hidden, tolerance {_mm(self.tolerance)}"


def select_in_lasso(
    xyz: Floats,
    allowed: Bools | None,
    view: View,
    polygon: Floats,
    mode: Mode,
    tolerance: float | None = None,
    splat: int = 2,
) -> LassoResult:
    """Select the points inside a freehand polygon; a pure function of its arguments.

    Parameters
    ----------
    xyz : (n, 3) float64 array
        All points of the scan, in world metres.
    allowed : (n,) bool array or None
        Points that are shown; the others are neither selected nor hide anything.
    view : View
    polygon : (k, 2) array
        Corners as fractions of the viewport, (0, 0) upper left, (1, 1) lower right.
    mode : {'visible', 'through'}
    tolerance : float or None
        Metres. None: 5 pixels at the median depth of the points in the lasso, at least 2 mm.
    splat : int
        Side in pixels of the square that a point covers.

    Returns
    -------
    LassoResult

    Raises
    ------
    BadInput
        A polygon, splat or tolerance that makes no sense.
    WrongUse
        An unknown mode.
    """
    if mode not in ("visible", "through"):
        raise WrongUse(f"A lasso selects 'visible' or 'through', not {mode!r}.")
    where = project(xyz, view.origin, view.matrix, view.size)
    shown = where.inside if allowed is None else where.inside & allowed
    corners = np.asarray(polygon, dtype=np.float64) * view.size
    caught = shown & lasso_mask(where.px, corners, view.size)
    if mode == "through":
        return LassoResult(np.flatnonzero(caught), 0, 0.0, mode)
    if tolerance is None:
        tolerance = choose_tolerance(view, where, caught)
    seen = visible_mask(where.px, where.depth, shown, view.size, splat, tolerance)
    indices = np.flatnonzero(caught & seen)
    return LassoResult(indices, int(np.count_nonzero(caught)) - len(indices), tolerance, mode)


def choose_tolerance(view: View, where: Projected, caught: Bools) -> float:
    """Depth tolerance in metres that fits the size of a pixel at the caught points."""
    if not caught.any():
        return SMALLEST_TOLERANCE
    pixel = view.pixel_size(float(np.median(where.depth[caught])))
    return max(SMALLEST_TOLERANCE, TOLERANCE_PIXELS * pixel)


def _mm(metres: float) -> str:
    millimetres = to_mm(metres)
    return f"{millimetres:.2g} mm" if millimetres < 10.0 else f"{millimetres:.0f} mm"
