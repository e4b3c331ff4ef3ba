"""The surfaces along the beam of a point, as the clean beams around tell them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.footprint import BeamShape
from app.core.ghosts.image import GhostImage, lay_over
from app.core.progress import QUIET, Progress

GAP = 0.012
"""Metres of range between beams of two surfaces, beside what a steep one needs."""
PIECE = 4_000
TINY = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class BeamSurfaces:
    """Surfaces along beams, (k, 3) each: the nearest in range to the point first; NaN without.

    Attributes
    ----------
    distance : metres
        From the scanner, where the beam meets the surface carried on.
    scatter : metres
        Of the beams about the plane through them.
    share : 0 to 1
        Of the weight of all surfaces here, beams weighing by how near they are.
    beams : how many make the surface; 0 without
    light : mean of what is given of each point
    slope : range over breadth at the range of the point
        Times the point's range over `distance`: tangent of the angle of incidence.
    away : cells
        From the point to the nearest beam that is of the surface.
    nearest : int16, (k, 3, 3)
        Where that beam is: layer of the image, rows and columns from the point; 0 without.
    """

    distance: Floats
    scatter: Floats
    share: Floats
    beams: Floats
    light: Floats
    slope: Floats
    away: Floats
    nearest: AnyArray


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What surfaces are carried on from, (layers, rows, columns) each, as the image's ranges.

    Attributes
    ----------
    image : GhostImage
    inverse : float32, one over metres
    trust : float32
        How much a beam counts: more, the farther from a mixed one; 0: not at all.
    bright : float32
        Whatever has its mean over each surface taken; NaN without.
    """

    image: GhostImage
    inverse: AnyArray
    trust: AnyArray
    bright: AnyArray


def lay_ground(image: GhostImage, mixed: Bools, light: AnyArray | None = None) -> Ground:
    """Prepare to carry surfaces on.

    Beams farther from a mixed one count more: those beside a border are drawn to the other side.

    Parameters
    ----------
    image : GhostImage
    mixed : (n,) bool
        Points that support nothing.
    light : (n,) or None
        Anything whose mean over each surface is wanted.
    """
    from app.core.kernels import ghost_surfaces as kernels

    laid, depth = lay_over(image, mixed, False), np.empty(image.ranges.shape, np.uint8)
    for layer, ranges in enumerate(image.ranges):
        kernels.measure_depth(ranges, laid[layer], depth[layer])
    trust = np.concatenate([[0.0], 4.0 ** np.arange(1, kernels.DEEPEST + 1)]).astype(np.float32)
    unknown = np.float32(np.nan)
    if light is None:
        bright = np.full(image.ranges.shape, unknown)
    else:
        bright = lay_over(image, np.asarray(light, np.float32), unknown)
    return Ground(image, np.reciprocal(image.ranges), trust[depth], bright)


def find_surfaces(
    ground: Ground, points: Ints, beam: BeamShape, progress: Progress = QUIET
) -> BeamSurfaces:
    """Carry the surfaces around on to the beams of some points.

    Parameters
    ----------
    ground : Ground
    points : (k,) numbers
    beam : (radius in metres, half divergence in radians)
    progress : Progress
    """
    from app.core.kernels import ghost_surfaces as kernels

    image = ground.image
    cells, steps = image.cells, image.steps
    found = np.empty((len(points), kernels.SURFACES, kernels.PER_SURFACE))
    radius, spread = beam[0], float(np.tan(beam[1]))

    def work(first: int, last: int) -> None:
        kernels.find_surfaces(
            points[first:last], image.own, cells.row, cells.column, image.ranges, ground.inverse,
            ground.trust, ground.bright, steps.down, steps.across, radius, spread, GAP,
            found[first:last],
        )  # fmt: skip

    run_in_pieces(work, split_evenly(len(points), PIECE), progress, "surfaces behind ghosts")
    distance, scatter, light, slope, away, mass, beams = np.ascontiguousarray(
        np.moveaxis(found[:, :, : kernels.NEAR_LAYER], 2, 0)
    )
    share = mass / np.maximum(mass.sum(axis=1, keepdims=True), TINY)
    nearest = found[:, :, kernels.NEAR_LAYER :].astype(np.int16)
    return BeamSurfaces(distance, scatter, share, beams, light, slope, away, nearest)


def number_members(image: GhostImage, points: Ints, surfaces: BeamSurfaces) -> Ints:
    """Number of the point of each surface whose beam is nearest, (k, 3); -1 without."""
    from app.core.kernels.ghost_image import MARGIN

    laid = lay_over(image, np.arange(len(image.own)), np.int64(-1))
    layer, down, across = np.moveaxis(surfaces.nearest, 2, 0)
    y = image.cells.row[points, None] + MARGIN + down
    x = image.cells.column[points, None] + MARGIN + across
    return np.where(np.isfinite(surfaces.distance), laid[layer, y, x], -1)
