"""The scan as its ranges in rows and columns, with room for several returns of a beam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.neighbours.steps import Cells, ScanGrid, Steps, as_cells, measure_steps

MOST_LAYERS = 4
"""Returns of one beam that are looked at; scanners that tell more are rare."""


@dataclass(frozen=True, slots=True, eq=False)
class GhostImage:
    """Ranges of a scan in its rows and columns.

    Attributes
    ----------
    own : (n,) metres
        Range of each point; NaN or 0 without one.
    cells : Cells
    layer : (n,) uint8
        Which of the returns of its beam a point is.
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
    from app.core.kernels import ghost_evidence as kernels

    cells = as_cells(grid)
    steps = measure_steps(xyz, scanner, cells)
    with np.errstate(invalid="ignore", over="ignore"):
        own: Floats = np.sqrt(((xyz - scanner) ** 2).sum(axis=1))
    layer = _tell_layers(cells)
    margin = kernels.MARGIN
    layers = min(int(layer.max(initial=0)) + 1, MOST_LAYERS)
    shape = (layers, cells.rows + 2 * margin, cells.columns + 2 * margin)
    ranges = np.full(shape, np.nan, np.float32)
    kernels.lay_out(own, cells.row, cells.column, layer, ranges)
    if steps.seam and cells.columns >= margin:
        ranges[:, :, :margin] = ranges[:, :, -2 * margin : -margin]
        ranges[:, :, -margin:] = ranges[:, :, margin : 2 * margin]
    return GhostImage(own, cells, layer, ranges, steps)


def _tell_layers(cells: Cells) -> AnyArray:
    """Number of each point among those of its cell, in the order of the file."""
    place = cells.row.astype(np.int64) * cells.columns + cells.column
    taken = np.bincount(place, minlength=1)
    if taken.max(initial=0) <= 1:
        return np.zeros(len(place), np.uint8)
    order = np.argsort(place, kind="stable")
    first = np.concatenate([[0], np.cumsum(taken)[:-1]])
    layer = np.empty(len(place), np.uint8)
    layer[order] = np.minimum(np.arange(len(place)) - first[place[order]], 255)
    return layer
