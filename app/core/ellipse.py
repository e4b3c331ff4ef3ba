"""Areas inside and around an ellipse: places that lie so far within, or outside, its border."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from app.core.arrays import Floats


def parallel_area(one: npt.ArrayLike, other: npt.ArrayLike, within: npt.ArrayLike) -> Floats:
    """Area of the places that lie at least so far within an ellipse.

    The border of that area runs parallel to the ellipse. Its area is ½ ∫ h ρ dφ over the
    direction φ of the normal, with the support h = √(a² cos²φ + b² sin²φ) − t and the radius of
    curvature ρ = a² b² / (h + t)³ − t (Steiner 1840), and an elliptic integral of the second kind.
    Where the parallel curve crosses itself, at the ends of a slim ellipse, φ begins at the
    crossing.

    Parameters
    ----------
    one, other : array_like
        Half axes in any order, metres, ≥ 0.
    within : array_like
        t: metres from the border inwards; negative ones lie outside, and the area is larger
        than the ellipse.

    Returns
    -------
    array
        Square metres, broadcast; 0 where no place lies so far within.
    """
    from scipy.special import ellipe, ellipeinc

    first, second, t = np.broadcast_arrays(
        np.asarray(one, np.float64), np.asarray(other, np.float64), np.asarray(within, np.float64)
    )
    a, b = np.maximum(first, second), np.minimum(first, second)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slim = np.where(a > 0.0, 1.0 - (b / a) ** 2, 0.0)
        cosine = ((b * b / np.maximum(t, 0.0)) ** 2 - b * b) / (a * a - b * b)
        start = np.where(t * a > b * b, np.arccos(np.sqrt(np.clip(cosine, 0.0, 1.0))), 0.0)
        sine, cos = np.sin(start), np.cos(start)
        support = np.sqrt((a * cos) ** 2 + (b * sine) ** 2)
        sector = a * b * (np.pi / 2 - np.arctan2(b * sine, a * cos))
        length = a * (ellipe(slim) - ellipeinc(start, slim))
        turning = np.where(support > 0.0, (b * b - a * a) * sine * cos / support, 0.0)
        quarter = (sector - t * (2.0 * length - turning) + t * t * (np.pi / 2 - start)) / 2.0
    area: Floats = np.where(t >= b, 0.0, np.maximum(4.0 * quarter, 0.0))
    return np.where((t >= b) & (t <= 0.0), 4.0 * quarter, area)
