"""Writer of PTX: one line per cell of the grid, column by column, beams without echo too."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints, finite_rows
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.ptx_header import ScanHeader
from app.model.scan import Grid

_CHUNK = 50_000  # cells
_DECIMALS = 6  # micrometres
_POINT = f"%.{_DECIMALS}f %.{_DECIMALS}f %.{_DECIMALS}f %.7g\n"
_NO_POINT = "0 0 0 0.5\n"
_NO_CHANNEL = 0.5
_STRONGEST = 2047.0
_ELSEWHERE = "Export it as E57 or LAZ."


def write(path: Path, cloud: Cloud, progress: Progress) -> dict[str, AnyArray]:
    """Write a cloud as one scan, in the scanner's own system where its pose is known.

    The intensity is the first channel, as it is; 0.5 throughout where there is none. A cell
    without a point is written as a beam without echo; which ones really were is left to the
    sidecar.

    Parameters
    ----------
    path : Path
    cloud : Cloud
    progress : Progress

    Returns
    -------
    dict of str to (n,) arrays
        All columns but rows and columns of the grid, in the order of the file: PTX has no
        place for them.

    Raises
    ------
    BadInput
        The cloud has no grid, a cell holds several points, a point is not finite or lies at
        the scanner, or the intensity is beyond -2047 to 2047.
    """
    grid = cloud.scan.grid
    if grid is None:
        raise BadInput(f"{cloud.scan.name} has no rows and columns, PTX needs them.", _ELSEWHERE)
    cells, order = _sort_cells(grid)
    header = ScanHeader.of(grid, cloud.scan.pose)
    table = np.column_stack((_place(header, cloud.scan.xyz), _choose_intensity(cloud)))[order]
    with path.open("wb") as file:
        file.write(header.format().encode("ascii"))
        for start in range(0, header.cells, _CHUNK):
            progress.report(start / header.cells, "Writing PTX")
            stop = min(start + _CHUNK, header.cells)
            first, last = np.searchsorted(cells, (start, stop))
            file.write(_format_cells(cells[first:last] - start, table[first:last], stop - start))
    left = {name: v for name, v in cloud.columns.items() if name not in ("row", "column")}
    return {name: values[order] for name, values in left.items()}


def _sort_cells(grid: Grid) -> tuple[Ints, Ints]:
    """Numbers of the cells that hold a point, in the order of the file, and their points."""
    cells = grid.column.astype(np.int64) * grid.rows + grid.row
    order = np.argsort(cells, kind="stable")
    cells = cells[order]
    shared = int(np.count_nonzero(np.diff(cells) == 0))
    if shared:
        raise BadInput(
            f"PTX holds one point per cell, and {shared} points share a cell with another one.",
            _ELSEWHERE,
        )
    return cells, order


def _place(header: ScanHeader, xyz: Floats) -> Floats:
    if not finite_rows(xyz).all():
        raise BadInput(
            "PTX has no place for points whose coordinates are not finite.",
            "Export them as E57, PLY or NPZ, or leave them out.",
        )
    local = header.to_file(xyz)
    at_zero = ~np.round(local, _DECIMALS).any(axis=1)
    if at_zero.any():
        raise BadInput(
            f"{int(at_zero.sum())} points lie at the scanner: PTX takes such for no echo.",
            "Leave them out, or export as E57 or LAZ.",
        )
    return local


def _choose_intensity(cloud: Cloud) -> Floats:
    if not cloud.scan.channels:
        return np.full(len(cloud.scan), _NO_CHANNEL)
    channel = cloud.scan.channels[0]
    values = cloud.columns[channel.attribute].astype(np.float64)
    if not np.all(np.abs(values) <= _STRONGEST):
        raise BadInput(
            f"{channel.name} has values that PTX cannot hold: an intensity lies in 0 to 1 or in"
            f" -{_STRONGEST:.0f} to {_STRONGEST:.0f}.",
            _ELSEWHERE,
        )
    return values


def _format_cells(cells: Ints, table: Floats, count: int) -> bytes:
    """Lines of `count` cells, of which some (their numbers) hold the points of `table`."""
    lines = np.full(count, _NO_POINT, dtype=object)
    lines[cells] = _POINT
    # One long format string: twice as fast as a line at a time.
    return ("".join(lines.tolist()) % tuple(table.ravel().tolist())).encode("ascii")
