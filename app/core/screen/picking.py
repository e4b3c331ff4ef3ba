"""The point under the cursor."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Bools
from app.core.screen.projection import Pixels
from app.core.screen.visibility import visible_mask


def pick(
    px: Pixels,
    depth: Pixels,
    mask: Bools,
    position: tuple[float, float],
    radius_px: float,
    splat: int = 3,
) -> int:
    """Index of the point that a click means, or −1.

    Of the points within the radius, those stay that no nearer point covers (squares of
    `splat` pixels); of these the one closest to the cursor is taken, at equal distance the
    one in front.

    Parameters
    ----------
    px, depth : (n, 2), (n,) float32 arrays
        As `project` gives them.
    mask : (n,) bool array
        Points that may be picked: in the frustum and not deleted.
    position : (x, y)
        Cursor in pixels, y down.
    radius_px : float
    splat : int

    Returns
    -------
    int
    """
    reach = radius_px + splat
    near = np.flatnonzero(
        mask & (np.abs(px[:, 0] - position[0]) <= reach) & (np.abs(px[:, 1] - position[1]) <= reach)
    )
    if not len(near):
        return -1
    corner = np.floor(np.asarray(position) - reach)
    side = int(2 * reach) + 3
    here = (px[near] - corner).astype(np.float32)
    seen = visible_mask(here, depth[near], np.ones(len(near), bool), (side, side), splat)
    distance = np.hypot(px[near, 0] - position[0], px[near, 1] - position[1])
    order = np.lexsort((near, depth[near], distance))
    best = order[(seen & (distance <= radius_px))[order]]
    return int(near[best[0]]) if len(best) else -1
