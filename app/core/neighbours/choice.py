"""Which way neighbours are found in a scan, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.neighbours.recovered import Recovered, recover
from app.core.neighbours.steps import ScanGrid, UnusableGrid
from app.core.progress import QUIET, Progress

Method = Literal["scan grid", "recovered grid", "voxel hash"]


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """How neighbours are found.

    Attributes
    ----------
    grid : ScanGrid or None
        Rows and columns; None means by voxels.
    method : {'scan grid', 'recovered grid', 'voxel hash'}
    reason : str
        One clause.
    """

    grid: ScanGrid | None
    method: Method
    reason: str


def choose_neighbours(
    xyz: Floats, scanner: AnyArray | None, grid: ScanGrid | None, progress: Progress = QUIET
) -> Neighbours:
    """Take the grid that there is, else try to recover one, else voxels.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres, or None where it is unknown
    grid : ScanGrid or None
        Taken as it is.
    progress : Progress

    Raises
    ------
    Cancelled
    """
    if grid is not None:
        return Neighbours(grid, "scan grid", "rows and columns are in the file")
    if scanner is None:
        return Neighbours(None, "voxel hash", "the scanner's position is unknown")
    try:
        found = recover(xyz, np.asarray(scanner, dtype=np.float64), progress)
    except UnusableGrid as refusal:
        return Neighbours(None, "voxel hash", str(refusal))
    return Neighbours(found.cells, "recovered grid", _describe(found))


def _describe(found: Recovered) -> str:
    cells = found.cells
    down, across = np.rad2deg(found.step)
    rows, columns = (f"{lines:,}".replace(",", " ") for lines in (cells.rows, cells.columns))
    return (
        f"recovered from the directions of the points: {down:.3g}° × {across:.3g}°, "
        f"{rows} × {columns} cells"
    )
