"""How far off the angle of a leaf's plane may be, told by its points."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats

BLOCKS = 5
"""Blocks along each side of the leaf's picture."""
FEWEST = 6
"""Blocks with points below which the error is unknown."""


def error_of_angle(offsets: Floats, normal: Floats, back: AnyArray) -> float:
    """Standard error of the angle at which the beam meets a plane.

    The plane 1 / z = α + β a + γ b is linear in the tangents a, b of the beams. What noise along
    the beams leaves uncertain in its three numbers is taken from the residuals, summed over 5 × 5
    blocks of the leaf's picture (sandwich of clusters: Liang and Zeger 1986, Biometrika 73), so
    that neighbours may share their noise, and wrinkles count. It is that of the least squares of
    ranges: other planes are a little less certain, and biased besides.

    Parameters
    ----------
    offsets : (k, 3) metres
        Members of the plane, about its point.
    normal : (3,)
        Unit vector.
    back : (3,) metres
        From the plane's point to the scanner.

    Returns
    -------
    float
        Radians; NaN where the points lie in too few blocks.
    """
    away = float(np.linalg.norm(back))
    ahead = -np.asarray(back, np.float64) / away
    tilt = normal - (normal @ ahead) * ahead
    steep, facing = float(np.linalg.norm(tilt)), float(normal @ ahead)
    # Of the two axes across the beam the first is that of the tilt; any, where there is none.
    first = tilt / steep if steep else np.linalg.svd(ahead[None])[2][1]
    second = np.cross(ahead, first)
    slope = steep / facing if facing else np.inf
    depth = 1.0 + offsets @ ahead / away
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (offsets @ axis / away / depth for axis in (first, second))
        inverse = 1.0 + slope * a
    seen = (inverse > 0.0) & (depth > 0.0)
    if not np.isfinite(slope) or not seen.any():
        return float("nan")
    a, b, fitted = a[seen], b[seen], away / inverse[seen]
    turn = -(fitted[:, None] ** 2) / away * np.stack([np.ones_like(a), a, b], axis=1)
    covariance = _sandwich(turn, away * depth[seen] - fitted, _number_blocks(a, b))
    # ω = atan(hypot(β, γ) / α), at α = 1 and γ = 0.
    gradient = np.array([-slope, 1.0, 0.0]) / (1.0 + slope**2)
    variance = float(gradient @ covariance @ gradient)
    return float("nan") if np.isnan(variance) else max(variance, 0.0) ** 0.5


def _number_blocks(a: Floats, b: Floats) -> AnyArray:
    places = []
    for values in (a, b):
        low, high = float(values.min()), float(values.max())
        place = (values - low) / max(high - low, np.finfo(float).tiny) * BLOCKS
        places.append(np.minimum(place.astype(np.int64), BLOCKS - 1))
    return np.asarray(places[0] * BLOCKS + places[1])


def _sandwich(turn: Floats, residual: Floats, block: AnyArray) -> Floats:
    """Covariance of three parameters, (3, 3); NaN of too few blocks, or where they are one."""
    pulls = np.stack(
        [np.bincount(block, turn[:, k] * residual, BLOCKS**2) for k in range(3)], axis=1
    )
    filled = len(np.unique(block))
    # Scaled, for a and b are hundredths and the inverse would lose digits.
    scale = np.sqrt((turn**2).sum(axis=0))
    if filled < FEWEST or not scale.all():
        return np.full((3, 3), np.nan)
    bread = np.linalg.pinv((turn / scale).T @ (turn / scale), hermitian=True)
    meat = (pulls / scale).T @ (pulls / scale) * filled / (filled - 3)
    return np.asarray(bread @ meat @ bread / np.outer(scale, scale))
