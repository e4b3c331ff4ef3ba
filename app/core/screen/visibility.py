"""Which points does the viewer see? A depth image of all points, never of the drawn ones only."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools
from app.core.errors import BadInput
from app.core.screen.projection import Pixels, for_kernel

LARGEST_SPLAT = 64


def visible_mask(
    px: Pixels,
    depth: Pixels,
    inside: Bools,
    size: tuple[int, int],
    splat: int = 2,
    tolerance: float = 0.0,
) -> Bools:
    """Points that no nearer point covers.

    Every point is drawn as a square of `splat` × `splat` pixels into a depth image. A point
    is seen when its depth is at most `tolerance` behind the front at its own pixel. The
    result does not depend on the order of the points.

    Parameters
    ----------
    px, depth : (n, 2), (n,) float32 arrays
        As `project` gives them.
    inside : (n,) bool array
        Points that take part: in the frustum and not deleted.
    size : (width, height)
    splat : int
        Side of the square in pixels, 1 to 64.
    tolerance : float
        Metres.

    Returns
    -------
    (n,) bool array

    Raises
    ------
    BadInput
        A splat or a tolerance that makes no sense.
    """
    from app.core.kernels import screen

    if not 1 <= splat <= LARGEST_SPLAT:
        raise BadInput(f"A point must cover 1 to {LARGEST_SPLAT} pixels, not {splat}.")
    if not tolerance >= 0.0:
        raise BadInput(f"A depth tolerance must be zero or more, not {tolerance}.")
    width, height = size
    front = np.full((height, width), np.inf, np.float32)
    places, depths = for_kernel(px, np.float32), for_kernel(depth, np.float32)
    drawn = for_kernel(inside, np.bool_)
    screen.splat(places, depths, drawn, int(splat), front)
    seen = np.empty(len(px), np.bool_)
    screen.in_front(places, depths, drawn, front, float(tolerance), seen)
    return seen
