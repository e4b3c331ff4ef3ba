"""E57 (ASTM E2807): several scans, pose, rows and columns, beams without echo, raw intensity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats
from app.core.progress import Progress
from app.formats.channels import recognise_channels
from app.formats.e57_notes import apply_notes
from app.formats.e57_preflight import SPHERICAL, ScanLayout, describe, read_layout
from app.formats.e57_write import write
from app.formats.guard import library_errors
from app.formats.header import Header
from app.formats.options import DEFAULTS, ReadOptions
from app.model.scan import Grid, Pose, Scan

__all__ = ["NAME", "SUFFIXES", "matches", "preflight", "read", "write"]

NAME = "E57"
SUFFIXES = (".e57",)
_CHUNK = 200_000
_LARGEST_GRID = 1 << 27  # cells
_CELLS_PER_RECORD = 1000
_NAMES = {"colorRed": "red", "colorGreen": "green", "colorBlue": "blue"}
_CELL = ("rowIndex", "columnIndex")


def matches(head: bytes, path: Path) -> bool:  # noqa: ARG001 (the magic decides)
    """Whether the file begins with ``ASTM-E57``."""
    return head[:8] == b"ASTM-E57"


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:  # noqa: ARG001
    """Check header and XML section without libE57; see `read_layout` for the errors."""
    return describe(read_layout(path))


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read all scans; coordinates are in the world where the file states a pose.

    Raises
    ------
    BadInput
        As `preflight`, and when libE57 finds damage (a wrong checksum, say).
    """
    layout = read_layout(path)
    scans = []
    for i, scan in enumerate(layout.scans):
        part = progress.part(i / len(layout.scans), (i + 1) / len(layout.scans))
        with library_errors(path, "libE57"):
            values = _read_records(path, scan, options.every_nth, part)
        made = _make_scan(scan, values)
        scans.append(replace(made, metadata={**layout.details, **made.metadata}))
    return scans


def _read_records(
    path: Path, scan: ScanLayout, every_nth: int, progress: Progress
) -> dict[str, AnyArray]:
    """Each n-th record, by the name of its elements; fewer where the file holds fewer."""
    rows = -(-scan.records // every_nth)
    values = {e.name: np.empty(rows, e.type) for e in scan.elements}
    seen = filled = 0
    for chunk in _read_chunks(path, scan):
        first = -seen % every_nth
        length = len(next(iter(chunk.values())))
        seen += length
        kept = len(range(first, length, every_nth))
        for name, part in chunk.items():
            values[name][filled : filled + kept] = part[first::every_nth]
        filled += kept
        progress.report(seen / scan.records, f"Reading {scan.name}")
    return {name: array[:filled] for name, array in values.items()}


def _read_chunks(path: Path, scan: ScanLayout) -> Iterator[dict[str, AnyArray]]:
    if scan.records == 0:
        return  # nothing is asked of the library: such files often have no section at all
    from pye57 import libe57

    capacity = min(_CHUNK, scan.records)
    image = libe57.ImageFile(str(path), "r")
    try:
        points = image.root()["data3D"][scan.index]["points"]
        buffers, arrays = libe57.VectorSourceDestBuffer(), {}
        for element in scan.elements:
            arrays[element.name] = array = np.zeros(capacity, transport_type(element.type))
            buffers.append(
                libe57.SourceDestBuffer(image, element.name, array, capacity, True, True)
            )
        reader = points.reader(buffers)
        left = scan.records
        while left > 0 and (count := min(reader.read(), left)):
            left -= count
            yield {name: array[:count] for name, array in arrays.items()}
        reader.close()
    finally:
        image.close()


def transport_type(type_name: str) -> np.dtype[Any]:
    """The type of a buffer: pye57 takes numpy's int64 for 32 bits, but not its longlong."""
    return np.dtype(np.longlong) if type_name in ("u4", "i4", "i8") else np.dtype(type_name)


def _make_scan(layout: ScanLayout, values: dict[str, AnyArray]) -> Scan:
    local = _local_coordinates(layout, values)
    gridded = set(_CELL) <= set(values)
    silent = _find_silent(layout, values, local, gridded)
    grid, notes = _make_grid(layout, values, silent) if gridded else (None, ())
    used = {*layout.coordinates, _state_name(layout), *(_CELL if grid else ())}
    attributes = {
        _NAMES.get(name, name): array[~silent] for name, array in values.items() if name not in used
    }
    scan = Scan(
        name=layout.name,
        xyz=_to_world(local[~silent], layout.pose),
        attributes=attributes,
        channels=recognise_channels(attributes),
        pose=layout.pose,
        grid=grid,
        metadata={**layout.metadata, "beams without echo": str(int(silent.sum()))},
        warnings=layout.warnings + notes + _list_warnings(layout, silent, grid),
    )
    return apply_notes(scan, layout.notes)


def _local_coordinates(layout: ScanLayout, values: Mapping[str, AnyArray]) -> Floats:
    first, second, third = (values[name].astype(np.float64) for name in layout.coordinates)
    if layout.coordinates != SPHERICAL:
        return np.column_stack((first, second, third))
    flat = first * np.cos(third)
    return np.column_stack((flat * np.cos(second), flat * np.sin(second), first * np.sin(third)))


def _state_name(layout: ScanLayout) -> str:
    spherical = layout.coordinates == SPHERICAL
    return "sphericalInvalidState" if spherical else "cartesianInvalidState"


def _find_silent(
    layout: ScanLayout, values: Mapping[str, AnyArray], local: Floats, gridded: bool
) -> Bools:
    """Records without a point: marked invalid, or at range 0 where beams are recorded."""
    silent = np.zeros(len(local), bool)
    state = values.get(_state_name(layout))
    if state is not None:
        silent |= state != 0
    if layout.coordinates == SPHERICAL:
        silent |= values[SPHERICAL[0]] == 0
    elif gridded:
        silent |= ~local.any(axis=1)
    return silent


def _make_grid(
    layout: ScanLayout, values: Mapping[str, AnyArray], silent: Bools
) -> tuple[Grid | None, tuple[str, ...]]:
    row: AnyArray = values[_CELL[0]].astype(np.int64)
    column: AnyArray = values[_CELL[1]].astype(np.int64)
    if len(row) == 0:
        return None, ()
    first_row, last_row, first_column, last_column = _cell_bounds(layout, row, column)
    rows, columns = last_row - first_row + 1, last_column - first_column + 1
    if not _is_plausible(rows, columns, len(row)):
        return None, (f"A grid of {rows} × {columns} cells for {len(row)} records: left out.",)
    row, column = row - first_row, column - first_column
    cells = row * columns + column
    empty = np.setdiff1d(cells[silent], cells[~silent])  # one echo of several may be missing
    row, column = row[~silent].astype(np.int32), column[~silent].astype(np.int32)
    return Grid(rows, columns, row, column, empty), ()


def _cell_bounds(layout: ScanLayout, row: AnyArray, column: AnyArray) -> tuple[int, int, int, int]:
    """The bounds that the file states where they hold its records, else those of the records."""
    real = int(row.min()), int(row.max()), int(column.min()), int(column.max())
    stated = layout.bounds
    if stated is None or not _is_plausible(
        stated[1] - stated[0] + 1, stated[3] - stated[2] + 1, len(row)
    ):
        return real
    inside = stated[0] <= real[0] and real[1] <= stated[1]
    inside = inside and stated[2] <= real[2] and real[3] <= stated[3]
    return stated if inside else real


def _is_plausible(rows: int, columns: int, records: int) -> bool:
    most = min(_LARGEST_GRID, _CELLS_PER_RECORD * records + 1_000_000)
    return rows > 0 and columns > 0 and rows * columns <= most


def _to_world(local: Floats, pose: Pose | None) -> Floats:
    if pose is None:
        return local
    world: Floats = local @ np.array(pose.rotation).T + np.array(pose.position)
    return world


def _list_warnings(layout: ScanLayout, silent: Bools, grid: Grid | None) -> tuple[str, ...]:
    warnings = []
    if len(silent) == 0:
        warnings.append(f"{layout.name} holds no points.")
    if silent.any() and grid is None:
        warnings.append(f"{int(silent.sum())} records without a point were left out.")
    return tuple(warnings)
