"""The surfaces along the beam of a point, as the clean beams around tell them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.footprint import BeamShape
from app.core.ghosts.image import GhostImage
from app.core.progress import QUIET, Progress

GAP = 0.012
"""Metres of range between beams of two surfaces, beside what a steep one needs."""
PIECE = 4_000


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
    slope : tangent of the angle of incidence
    away : cells
        From the point to the nearest beam that is of the surface.
    member : int64
        Number of the point of that beam; -1 without.
    """

    distance: Floats
    scatter: Floats
    share: Floats
    beams: Floats
    light: Floats
    slope: Floats
    away: Floats
    member: Ints


def find_surfaces(
    image: GhostImage, mixed: Bools, points: Ints, beam: BeamShape,
    light: AnyArray | None = None, progress: Progress = QUIET,
) -> BeamSurfaces:  # fmt: skip
    """Carry the surfaces around on to the beams of some points.

    Beams farther from a mixed one count more: those beside a border are drawn to the other side.

    Parameters
    ----------
    image : GhostImage
    mixed : (n,) bool
        Points that support nothing.
    points : (k,) numbers
    beam : (radius in metres, half divergence in radians)
    light : (n,) or None
        Anything whose mean over each surface is wanted.
    progress : Progress
    """
    from app.core.kernels import ghost_surfaces as kernels

    cells, steps, ranges = image.cells, image.steps, image.ranges[0]
    depth = np.empty(ranges.shape, np.uint8)
    kernels.measure_depth(ranges, lay_over(image, mixed, False), depth)
    bright = np.full(ranges.shape, np.nan, np.float32)
    if light is not None:
        bright = lay_over(image, np.asarray(light, np.float32), np.float32(np.nan))
    found = np.full((len(points), kernels.SURFACES, kernels.PER_SURFACE), np.nan)
    radius, spread = beam[0], float(np.tan(beam[1]))

    def work(first: int, last: int) -> None:
        kernels.find_surfaces(
            points[first:last], image.own, cells.row, cells.column, ranges, depth, bright,
            steps.down, steps.across, radius, spread, GAP, found[first:last],
        )  # fmt: skip

    run_in_pieces(work, split_evenly(len(points), PIECE), progress, "surfaces behind ghosts")
    return _name(image, points, found)


def _name(image: GhostImage, points: Ints, found: Floats) -> BeamSurfaces:
    from app.core.kernels import ghost_surfaces as kernels

    own, row, column = image.own[points], image.cells.row[points], image.cells.column[points]
    down, across = own * image.steps.down[column], own * image.steps.across[row]
    mass = np.nan_to_num(found[:, :, kernels.MASS])
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.hypot(
            found[:, :, kernels.DOWN] / down[:, None], found[:, :, kernels.ACROSS] / across[:, None]
        )
        share = mass / mass.sum(axis=1, keepdims=True)
    return BeamSurfaces(
        found[:, :, kernels.RANGE],
        found[:, :, kernels.SCATTER],
        np.nan_to_num(share),
        np.nan_to_num(found[:, :, kernels.SIZE]),
        found[:, :, kernels.LIGHT],
        slope,
        np.hypot(found[:, :, kernels.NEAR_DOWN], found[:, :, kernels.NEAR_ACROSS]),
        _number_members(image, points, found),
    )


def _number_members(image: GhostImage, points: Ints, found: Floats) -> Ints:
    from app.core.kernels import ghost_surfaces as kernels
    from app.core.kernels.ghost_evidence import MARGIN

    laid = lay_over(image, np.arange(len(image.own)), np.int64(-1))
    row, column = image.cells.row[points, None], image.cells.column[points, None]
    down, across = found[:, :, kernels.NEAR_DOWN], found[:, :, kernels.NEAR_ACROSS]
    known = np.isfinite(down)
    y = row + MARGIN + np.where(known, down, 0.0).astype(np.int64)
    x = column + MARGIN + np.where(known, across, 0.0).astype(np.int64)
    return np.where(known, laid[y, x], -1)


def lay_over(image: GhostImage, values: AnyArray, empty: object) -> AnyArray:
    """Values of the points in an array of the image's shape, of the first return of each beam."""
    from app.core.kernels.ghost_evidence import MARGIN

    laid = np.full(image.ranges.shape[1:], empty, values.dtype)
    first = slice(None) if image.ranges.shape[0] == 1 else np.flatnonzero(image.layer == 0)
    row, column = image.cells.row[first], image.cells.column[first]
    laid[row + MARGIN, column + MARGIN] = values[first]
    if image.steps.seam and image.cells.columns >= MARGIN:
        laid[:, :MARGIN] = laid[:, -2 * MARGIN : -MARGIN]
        laid[:, -MARGIN:] = laid[:, MARGIN : 2 * MARGIN]
    return laid
