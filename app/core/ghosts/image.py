"""The scan as its ranges in rows and columns, with room for several returns of a beam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.footprint import BeamShape
from app.core.neighbours.asked import as_points
from app.core.neighbours.steps import Cells, ScanGrid, Steps, UnusableGrid, as_cells, measure_steps


@dataclass(frozen=True, slots=True, eq=False)
class GhostImage:
    """Ranges of a scan in its rows and columns.

    Attributes
    ----------
    own : (n,) metres
        Range of each point; NaN or 0 without one.
    cells : Cells
    layer : (n,) uint8
        Which of the returns of its beam a point is, the nearest first.
    ranges : (layers, rows + 2 · MARGIN, columns + 2 · MARGIN) float32, metres
        NaN where there is none; columns go on around a full turn.
    steps : Steps
    """

    own: Floats
    cells: Cells
    layer: AnyArray
    ranges: AnyArray
    steps: Steps


def lay_out(xyz: Floats, scanner: Floats, grid: ScanGrid) -> GhostImage:
    """Lay a scan out.

    Raises
    ------
    BadInput
        The grid belongs to other points.
    UnusableGrid
        It is nearly empty, or its cells do not follow the beams from this position.
    """
    from app.core.kernels import ghost_image as kernels

    xyz, cells = as_points(xyz), as_cells(grid)
    steps = measure_steps(xyz, scanner, cells)
    own = np.empty(len(xyz))
    kernels.measure_ranges(xyz, scanner, own)
    layer = np.zeros(len(own), np.uint8)
    ranges, several = _lay_ranges(own, cells, layer)
    if several:
        layer = _tell_layers(cells, own)
        ranges, _ = _lay_ranges(own, cells, layer)
    image = GhostImage(own, cells, layer, ranges, steps)
    _close_seam(image, ranges)
    return image


def _lay_ranges(own: Floats, cells: Cells, layer: AnyArray) -> tuple[AnyArray, bool]:
    """Ranges in their rows, columns and layers; and whether two of one beam share a layer."""
    from app.core.kernels import ghost_image as kernels

    layers = min(int(layer.max(initial=0)) + 1, kernels.MOST_LAYERS)
    around = 2 * kernels.MARGIN
    ranges = np.full((layers, cells.rows + around, cells.columns + around), np.nan, np.float32)
    return ranges, kernels.lay_ranges(own, cells.row, cells.column, layer, ranges)


def try_layout(xyz: Floats, scanner: Floats, grid: ScanGrid | None) -> GhostImage | None:
    """The same, or None where rows and columns are missing or of no use."""
    try:
        return None if grid is None else lay_out(xyz, scanner, grid)
    except UnusableGrid:
        return None


def lay_over(image: GhostImage, values: AnyArray, empty: object) -> AnyArray:
    """Values of the points in an array of the shape of the image's ranges."""
    from app.core.kernels import ghost_image as kernels

    cells, laid = image.cells, np.full(image.ranges.shape, empty, values.dtype)
    kernels.lay_values(values, cells.row, cells.column, image.layer, laid)
    _close_seam(image, laid)
    return laid


def measure_beams(image: GhostImage, points: Ints, beam: BeamShape) -> tuple[Floats, Floats]:
    """Step to the next beam and diameter of the beam at some points, metres, (k,) each."""
    own, steps = image.own[points], image.steps
    down, across = steps.down[image.cells.column[points]], steps.across[image.cells.row[points]]
    diameter: Floats = 2.0 * (beam.radius + own * np.tan(beam.half_divergence))
    return own * np.sqrt(down * across), diameter


def _close_seam(image: GhostImage, laid: AnyArray) -> None:
    """Let the columns go on around a full turn."""
    from app.core.kernels.ghost_image import MARGIN

    if image.steps.seam and image.cells.columns >= MARGIN:
        laid[:, :, :MARGIN] = laid[:, :, -2 * MARGIN : -MARGIN]
        laid[:, :, -MARGIN:] = laid[:, :, MARGIN : 2 * MARGIN]


def _tell_layers(cells: Cells, own: Floats) -> AnyArray:
    """Number of each point among those of its cell, by range: a file may tell them in any order."""
    place = cells.row.astype(np.int64) * cells.columns + cells.column
    taken = np.bincount(place, minlength=1)
    order = np.lexsort((own, place))
    first = np.concatenate([[0], np.cumsum(taken)[:-1]])
    layer = np.empty(len(place), np.uint8)
    layer[order] = np.minimum(np.arange(len(place)) - first[place[order]], 255)
    return layer
