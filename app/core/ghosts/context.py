"""What the surfaces around a point, and the beams beside it, add to the first glance."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.footprint import BeamShape
from app.core.ghosts.image import GhostImage, lay_over, measure_beams
from app.core.ghosts.network import Network
from app.core.ghosts.surfaces import PIECE, BeamSurfaces, find_surfaces, lay_ground
from app.core.neighbours.steps import noise_of_bends
from app.core.progress import QUIET, Progress

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
    "beam diameter over step",
    "step",
    "noise",
)
FINEST = 0.0005
FARTHEST = 9.0
"""Metres, for a surface that is not there."""
STEEPEST = 20.0
DIMMEST = 50.0
"""Noises of the light, beyond which more says no more."""
LEAST = 1e-4
WIDTHS, STEPS, NOISES = (0.5, 15.0), (0.0003, 0.01), (0.0002, 0.004)
"""Beam diameters over the step, steps and noises in metres of the lessons."""
LINES = 100
"""Rows of the image on which noise is measured."""


def weigh_beams(
    image: GhostImage, mixed: Bools, points: Ints, glance: Floats, beam: BeamShape,
    light: AnyArray | None, network: Network, progress: Progress = QUIET,
) -> tuple[Floats, Floats]:  # fmt: skip
    """What a network says of some points, (k,), and the range of their nearest surface, (k,).

    Parameters
    ----------
    image : GhostImage
    mixed : (n,) bool
        Points that support no surface.
    points : (k,) numbers
    glance : (n,) 0 to 1
        Of all points; 0 where there was no need to look.
    beam : BeamShape
    light : (n,) or None
        As it was recorded, or its logarithm.
    network : Network
        That weighs `NAMES`.
    progress : Progress
    """
    around = Surroundings(image, mixed, glance, beam, light)
    said, distance = np.empty(len(points)), np.empty(len(points))

    def work(first: int, last: int) -> None:
        rows, distance[first:last] = around.describe(points[first:last])
        said[first:last] = network.weigh(rows)

    run_in_pieces(work, split_evenly(len(points), PIECE), progress, "surfaces behind ghosts")
    return said, distance


class Surroundings:
    """What is around the points of a scan, in numbers of `NAMES`; parameters as `weigh_beams`."""

    def __init__(
        self, image: GhostImage, mixed: Bools, glance: Floats, beam: BeamShape,
        light: AnyArray | None,
    ) -> None:  # fmt: skip
        self._light = None if light is None else scale_light(image, light)
        self._ground, self._beam = lay_ground(image, mixed, self._light), beam
        self._glance = glance
        self._laid = lay_over(image, glance.astype(np.float32), np.float32(1.0))[0]

    def describe(self, points: Ints) -> tuple[AnyArray, Floats]:
        """Rows of numbers, (k, NAMES) float32, and the range of the nearest surface, (k,)."""
        image = self._ground.image
        surfaces = find_surfaces(self._ground, points, self._beam)
        with np.errstate(invalid="ignore", divide="ignore"):
            columns = [
                _logit(self._glance[points]),
                *_describe_surfaces(image.own[points], surfaces),
            ]
            columns += [*_look_beside(image, points, self._laid)]
            columns += _describe_light(points, surfaces, self._light)
            columns += _describe_beams(image, points, self._beam)
        return np.stack(columns, axis=1, dtype=np.float32), surfaces.distance[:, 0]


def _describe_surfaces(own: Floats, surfaces: BeamSurfaces) -> list[Floats]:
    off = own[:, None] - surfaces.distance
    columns: list[Floats] = []
    for k in range(3):
        away = _shrink(np.where(np.isnan(off[:, k]), FARTHEST, off[:, k]), FINEST, FARTHEST)
        columns += [away, np.abs(away), surfaces.share[:, k], np.log1p(surfaces.beams[:, k])]
    columns.append(_shrink(np.nan_to_num(surfaces.scatter[:, 0]), FINEST, FARTHEST))
    steep = np.minimum(np.nan_to_num(surfaces.slope), STEEPEST)
    columns += [np.log1p(steep[:, 0]), np.log1p(steep[:, 1])]
    columns.append((off[:, 0] * off[:, 1] < 0.0).astype(np.float64))
    return columns


def _logit(share: Floats) -> Floats:
    logit: Floats = np.log(share + LEAST) - np.log(1.0 - share + LEAST)
    return logit


def _shrink(value: Floats, unit: float, largest: float) -> Floats:
    """Sign and logarithm of a value in units."""
    shrunk: Floats = np.sign(value) * np.log1p(np.minimum(np.abs(value), largest) / unit)
    return shrunk


def _look_beside(image: GhostImage, points: Ints, laid: AnyArray) -> AnyArray:
    """Glances at the first returns of the eight beams beside, rising, (8, k); 1 where none is."""
    from app.core.kernels.ghost_image import MARGIN

    y, x = image.cells.row[points] + MARGIN, image.cells.column[points] + MARGIN
    beside = [laid[y + k // 3 - 1, x + k % 3 - 1] for k in range(9) if k != 4]
    return np.sort(np.stack(beside), axis=0)


def _describe_light(points: Ints, surfaces: BeamSurfaces, light: Floats | None) -> list[Floats]:
    if light is None:
        return [np.zeros(len(points))] * 3
    own = light[points]
    off = [np.nan_to_num(own - surfaces.light[:, k]) for k in (0, 1)]
    return [*(_shrink(value, 1.0, DIMMEST) for value in off), np.isfinite(own).astype(np.float64)]


def _describe_beams(image: GhostImage, points: Ints, beam: BeamShape) -> list[Floats]:
    """How fine the scan is, and how certain, within what the lessons held."""
    step, diameter = measure_beams(image, points, beam)
    noise = np.full(len(points), np.clip(image.steps.noise, *NOISES))
    return [
        np.log(np.clip(diameter / step, *WIDTHS)), np.log(np.clip(step, *STEPS) / FINEST),
        np.log1p(noise / FINEST),
    ]  # fmt: skip


def scale_light(image: GhostImage, light: AnyArray) -> Floats | None:
    """Light in standard deviations of its noise, as it jumps along the rows; None: no noise told.

    So an amplifier, logarithmic or not, makes no difference.
    """
    laid = lay_over(image, np.asarray(light, np.float64), np.nan)[0]
    laid = laid[:: max(1, len(laid) // LINES)]
    with np.errstate(invalid="ignore"):
        bend = np.abs(laid[:, :-2] - 2.0 * laid[:, 1:-1] + laid[:, 2:])
    noise = noise_of_bends(bend)
    if not noise > 0.0:
        return None
    scaled: Floats = np.asarray(light, np.float64) / noise
    return scaled
