"""Loops over all points of the screen work: project, look up, depth image.

Serial on purpose: one pass each, bound by memory, and safe to call from any thread. No
fastmath and no BLAS, so that a stored selection gives the same points on every run.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from app.core.arrays import AnyArray, Bools, Floats


@njit(cache=True, nogil=True)
def project(
    xyz: Floats, origin: Floats, matrix: Floats, depth_row: Floats, width: float, height: float,
    px: AnyArray, depth: AnyArray, inside: Bools,
) -> None:  # fmt: skip
    """Pixels, view depth and frustum test of every point."""
    for i in range(len(xyz)):
        x = xyz[i, 0] - origin[0]
        y = xyz[i, 1] - origin[1]
        z = xyz[i, 2] - origin[2]
        clip_x = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]
        clip_y = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]
        clip_z = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]
        w = matrix[3, 0] * x + matrix[3, 1] * y + matrix[3, 2] * z + matrix[3, 3]
        # NaN fails every comparison, so such rows end in the else branch.
        if w > 0.0:
            px[i, 0] = (clip_x / w * 0.5 + 0.5) * width
            px[i, 1] = (0.5 - clip_y / w * 0.5) * height
            depth[i] = depth_row[0] * x + depth_row[1] * y + depth_row[2] * z + depth_row[3]
            # Tested on the rounded float32: 1919.99999 may have become 1920.
            inside[i] = 0.0 <= px[i, 0] < width and 0.0 <= px[i, 1] < height and -w <= clip_z <= w
        else:
            px[i, 0] = np.nan
            px[i, 1] = np.nan
            depth[i] = np.nan
            inside[i] = False


@njit(cache=True, nogil=True)
def look_up(px: AnyArray, picture: Bools, found: Bools) -> None:
    """Value of a boolean picture under every point; false outside the picture."""
    height, width = picture.shape
    for i in range(len(px)):
        x, y = px[i, 0], px[i, 1]
        if 0.0 <= x < width and 0.0 <= y < height:
            found[i] = picture[int(y), int(x)]
        else:
            found[i] = False


@njit(cache=True, nogil=True)
def splat(px: AnyArray, depth: AnyArray, drawn: Bools, size: int, front: AnyArray) -> None:
    """Lower `front` (height × width) to the nearest depth of the squares drawn on it."""
    height, width = front.shape
    shift = (size - 1) * 0.5
    for i in range(len(px)):
        if not drawn[i]:
            continue
        left = int(np.floor(px[i, 0] - shift))
        top = int(np.floor(px[i, 1] - shift))
        here = depth[i]
        for y in range(max(top, 0), min(top + size, height)):
            for x in range(max(left, 0), min(left + size, width)):
                front[y, x] = min(front[y, x], here)


@njit(cache=True, nogil=True)
def in_front(
    px: AnyArray, depth: AnyArray, drawn: Bools, front: AnyArray, tolerance: float, seen: Bools
) -> None:
    """Drawn points within `tolerance` behind the depth image at their own pixel."""
    height, width = front.shape
    for i in range(len(px)):
        x, y = px[i, 0], px[i, 1]
        seen[i] = False
        if drawn[i] and 0.0 <= x < width and 0.0 <= y < height:
            seen[i] = depth[i] <= front[int(y), int(x)] + tolerance
