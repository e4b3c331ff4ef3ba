"""The cells of a scan grid that a window of a stated half-width takes in."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from app.core.arrays import Bools, Floats, Ints
from app.core.neighbours.steps import measure_steps
from app.services.bench.incidence.scenes import Truth


def half_windows(truth: Truth, width: npt.ArrayLike) -> tuple[Ints, Ints]:
    """Rows and columns to either side that a half-width (metres) reaches at each point, (n,)."""
    steps = measure_steps(truth.xyz, truth.scanner, truth.grid)
    away = np.linalg.norm(truth.xyz - truth.scanner, axis=1)
    angle = np.nan_to_num(np.asarray(width, np.float64)) / away
    high = (angle / steps.down[truth.grid.column] + 0.5).astype(np.int64)
    wide = (angle / steps.across[truth.grid.row] + 0.5).astype(np.int64)
    return np.maximum(high, 1), np.maximum(wide, 1)


def integrate(image: Floats) -> Floats:
    """Sums over all cells above and left of each corner, (rows + 1, columns + 1, …)."""
    total = np.zeros((image.shape[0] + 1, image.shape[1] + 1, *image.shape[2:]))
    np.cumsum(np.cumsum(image, axis=0), axis=1, out=total[1:, 1:])
    return total


def sum_windows(total: Floats, truth: Truth, high: Ints, wide: Ints) -> Floats:
    """Sums over each point's window from the integral; what leaves the grid counts as 0."""
    rows, columns = truth.grid.rows, truth.grid.columns
    top = np.clip(truth.grid.row - high, 0, rows)
    low = np.clip(truth.grid.row + high + 1, 0, rows)
    left = np.clip(truth.grid.column - wide, 0, columns)
    right = np.clip(truth.grid.column + wide + 1, 0, columns)
    return np.asarray(total[low, right] - total[top, right] - total[low, left] + total[top, left])


def lie_undisturbed(truth: Truth, width: npt.ArrayLike) -> Bools:
    """Points whose window holds true points of their own leaf only, and no hole."""
    label = np.zeros((truth.grid.rows, truth.grid.columns), np.int64)
    label[truth.grid.row, truth.grid.column] = np.where(truth.judged, truth.leaf + 1, 0)
    bad = (label == 0).astype(np.float64)
    bad[:, :-1] += label[:, :-1] != label[:, 1:]
    bad[:-1] += label[:-1] != label[1:]
    high, wide = half_windows(truth, width)
    whole = (2 * high + 1) * (2 * wide + 1)
    inside = sum_windows(integrate(np.ones_like(bad)), truth, high, wide) == whole
    return np.asarray(inside & (sum_windows(integrate(bad), truth, high, wide) == 0.0))
