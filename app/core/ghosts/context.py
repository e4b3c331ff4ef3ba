"""What the surfaces around a point, and the beams beside it, add to the first glance."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.ghosts.image import GhostImage
from app.core.ghosts.surfaces import BeamSurfaces, lay_over

NAMES = (
    "glance",
    *(
        f"{what} {k}"
        for k in (1, 2, 3)
        for what in ("off surface", "distance from surface", "share of surface", "beams of surface")
    ),
    "scatter of surface 1",
    "slope of surface 1",
    "slope of surface 2",
    "between surfaces",
    *(f"glance beside {k}" for k in range(1, 9)),
    "light off surface 1",
    "light off surface 2",
    "light known",
)
FINEST = 0.0005
FARTHEST = 9.0
"""Metres, for a surface that is not there."""
STEEPEST = 20.0
DIMMEST = 50.0
"""Noises of the light, beyond which more says no more."""
LEAST = 1e-4


def describe_context(
    image: GhostImage, points: Ints, glance: Floats, surfaces: BeamSurfaces,
    light: Floats | None = None,
) -> AnyArray:  # fmt: skip
    """Numbers of `NAMES` for some points, (k, NAMES) float32.

    Parameters
    ----------
    image : GhostImage
    points : (k,) numbers
    glance : (n,) 0 to 1
        Of all points; 0 where there was no need to look.
    surfaces : BeamSurfaces
        Along the beams of `points`; its light is of the same kind as `light`.
    light : (n,) or None
        In standard deviations of its noise.
    """
    own = image.own[points]
    with np.errstate(invalid="ignore"):
        off = own[:, None] - surfaces.distance
        columns = [_logit(glance[points])]
        for k in range(3):
            away = _shrink(np.nan_to_num(off[:, k], nan=FARTHEST), FINEST, FARTHEST)
            columns += [away, np.abs(away), surfaces.share[:, k], np.log1p(surfaces.beams[:, k])]
        columns.append(_shrink(np.nan_to_num(surfaces.scatter[:, 0]), FINEST, FARTHEST))
        steep = np.minimum(np.nan_to_num(surfaces.slope), STEEPEST)
        columns += [np.log1p(steep[:, 0]), np.log1p(steep[:, 1])]
        columns.append((off[:, 0] * off[:, 1] < 0.0).astype(np.float64))
        columns += list(_look_beside(image, points, glance))
        columns += _describe_light(points, surfaces, light)
    return np.stack(columns, axis=1).astype(np.float32)


def _logit(share: Floats) -> Floats:
    logit: Floats = np.log(share + LEAST) - np.log(1.0 - share + LEAST)
    return logit


def _shrink(value: Floats, unit: float, largest: float) -> Floats:
    """Sign and logarithm of a value in units."""
    shrunk: Floats = np.sign(value) * np.log1p(np.minimum(np.abs(value), largest) / unit)
    return shrunk


def _look_beside(image: GhostImage, points: Ints, glance: Floats) -> Floats:
    """Glances at the eight beams beside each point, rising, (8, k); 1 where there is none."""
    from app.core.kernels.ghost_evidence import MARGIN

    laid = lay_over(image, glance.astype(np.float32), np.float32(1.0))
    y, x = image.cells.row[points] + MARGIN, image.cells.column[points] + MARGIN
    beside = [laid[y + k // 3 - 1, x + k % 3 - 1] for k in range(9) if k != 4]
    sorted_beside: Floats = np.sort(np.stack(beside), axis=0)
    return sorted_beside


def _describe_light(points: Ints, surfaces: BeamSurfaces, light: Floats | None) -> list[Floats]:
    if light is None:
        return [np.zeros(len(points))] * 3
    own = light[points]
    off = [np.nan_to_num(own - surfaces.light[:, k]) for k in (0, 1)]
    return [*(_shrink(value, 1.0, DIMMEST) for value in off), np.isfinite(own).astype(np.float64)]


def scale_light(image: GhostImage, light: AnyArray) -> Floats | None:
    """Light in standard deviations of its noise, as it jumps along the rows; None: no noise told.

    So an amplifier, logarithmic or not, makes no difference.
    """
    laid = lay_over(image, np.asarray(light, np.float64), np.nan)
    with np.errstate(invalid="ignore"):
        bend = np.abs(laid[:, :-2] - 2.0 * laid[:, 1:-1] + laid[:, 2:])
    bend = bend[np.isfinite(bend)]
    noise = float(np.median(bend)) / (0.6745 * np.sqrt(6.0)) if len(bend) else 0.0
    if not noise > 0.0:
        return None
    scaled: Floats = np.asarray(light, np.float64) / noise
    return scaled
