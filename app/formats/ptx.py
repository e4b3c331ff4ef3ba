"""PTX, the grid format of Leica: several scans, each with pose, rows and columns.

A scan is ten header lines (columns, rows, position, three axes, a 4 × 4 matrix in
row-vector convention), then one line per cell, column by column: the first ``rows``
lines are column 0 from row 0 on. A cell at 0 0 0 is a beam without echo.
All but coordinates and intensity of what we wrote ourselves lies beside it (`sidecar`,
`fields_file`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.channels import recognise_channels
from app.formats.fields_file import fields_path, find_fields
from app.formats.header import Header
from app.formats.line_blocks import LineReader
from app.formats.number_lines import parse_block, split_cells
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.ptx_header import ScanHeader, read_scan_header
from app.formats.ptx_write import write
from app.formats.sidecar import apply_sidecar, find_sidecar
from app.model.scan import Grid, Scan

__all__ = ["NAME", "SUFFIXES", "matches", "preflight", "read", "write"]

NAME = "PTX"
SUFFIXES = (".ptx",)
MOST_SCANS = 10_000
_ATTRIBUTES: Mapping[int, tuple[str, ...]] = {
    3: (),
    4: ("intensity",),
    6: ("red", "green", "blue"),
    7: ("intensity", "red", "green", "blue"),
}


def matches(head: bytes, path: Path) -> bool:
    """Two lines of one integer, then four of three numbers; or the suffix."""
    lines = head.decode("latin-1").split("\n")[:6]
    counts = [len(line.split()) for line in lines]
    begins = counts == [1, 1, 3, 3, 3, 3] and all(line.strip().isdigit() for line in lines[:2])
    return begins or path.suffix.lower() in SUFFIXES


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:
    """Walk over the headers and count the lines between them.

    Raises
    ------
    BadInput
        A header is no PTX header, or the file ends before its last cell
        (unless `options.recover`).
    """
    cells = attributes = scans = 0
    warnings: tuple[str, ...] = ()
    with LineReader(path) as reader:
        for part in _walk(path, reader, options):
            found = sum(_skip(reader, part.header.cells))
            warnings += _refuse_short(path, part, found, options)
            cells, scans = cells + found, scans + 1
            attributes = max(attributes, part.width)
    return Header(
        points=cells,
        scans=scans,
        attributes=_ATTRIBUTES[attributes],
        memory=cells * (8 * attributes + 8) * 2 + _size_beside(path),
        details={"cells": str(cells)},
        warnings=warnings,
    )


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read all scans; see the module for the order of rows.

    Raises
    ------
    BadInput
        As `preflight`, and for a line that is no cell.
    """
    scans = []
    with LineReader(path) as reader:
        for part in _walk(path, reader, options):
            scans.append(_read_scan(path, reader, part, options, progress))
    return scans if len(scans) > 1 else [_restore(path, scans[0], options, progress)]


def _size_beside(path: Path) -> int:
    beside = fields_path(path)
    return beside.stat().st_size if beside.is_file() else 0


def _restore(path: Path, scan: Scan, options: ReadOptions, progress: Progress) -> Scan:
    """The scan with what our writer put beside the file."""
    sidecar, doubts = find_sidecar(path)
    mark = None if sidecar is None else sidecar.fields
    fields, more = find_fields(path, mark, len(scan), options.every_nth, progress)
    scan = replace(scan, warnings=scan.warnings + doubts + more)
    if sidecar is None:
        return scan
    if fields is not None:
        scan = replace(scan, attributes=fields, channels=recognise_channels(fields))
    else:  # the intensity is the first channel: that is what our writer takes
        channels = tuple(replace(c, attribute="intensity") for c in sidecar.channels[:1])
        sidecar = replace(sidecar, channels=channels)
    return apply_sidecar(replace(scan, pose=sidecar.pose), sidecar)


@dataclass(frozen=True, slots=True)
class _Part:
    """A scan whose header was read: where it is, and how many numbers a cell has."""

    index: int
    header: ScanHeader
    width: int


def _walk(path: Path, reader: LineReader, options: ReadOptions) -> Iterator[_Part]:
    """Each scan in turn; the caller reads its cells before it asks for the next."""
    for index in range(MOST_SCANS + 1):
        header = read_scan_header(path, reader)
        if header is None:
            if index == 0:
                raise BadInput(f"{path.name} holds no scan.", "The file is empty.")
            return
        if index == MOST_SCANS:
            raise BadInput(f"{path.name} holds more than {MOST_SCANS} scans.", "Split it.")
        if header.cells * len("0 0 0\n") - 1 > reader.bytes_left and not options.recover:
            raise _too_short(path, index, header.cells)
        yield _Part(index, header, _peek_width(path, reader))


def _peek_width(path: Path, reader: LineReader) -> int:
    line = reader.peek()
    width = len(split_cells(line, None)) if line else 4
    if width not in _ATTRIBUTES:
        raise BadInput(
            f"{path.name}, line {reader.lines_read + 1}: a cell has {width} numbers.",
            "PTX has x y z, then intensity, red green blue, or both.",
        )
    return width


def _skip(reader: LineReader, lines: int) -> Iterator[int]:
    before = reader.lines_read
    for _ in reader.blocks(lines):
        yield reader.lines_read - before
        before = reader.lines_read


def _refuse_short(path: Path, part: _Part, found: int, options: ReadOptions) -> tuple[str, ...]:
    missing = part.header.cells - found
    if not missing:
        return ()
    if not options.recover:
        raise _too_short(path, part.index, part.header.cells)
    return (f"Scan {part.index + 1} ends early: {missing} of {part.header.cells} cells missing.",)


def _too_short(path: Path, index: int, cells: int) -> BadInput:
    return BadInput(
        f"{path.name} ends before scan {index + 1} has all the {cells} cells that it claims.",
        "The file is cut or damaged; --recover reads the complete cells.",
    )


def _read_scan(
    path: Path, reader: LineReader, part: _Part, options: ReadOptions, progress: Progress
) -> Scan:
    tables, cells, empty, found = [np.empty((0, part.width))], [], [], 0
    for block in reader.blocks(part.header.cells):
        progress.report(reader.fraction, f"Reading {path.name}")
        table = _parse_cells(path, reader, block, part.width, options)
        echo = np.any(table[:, :3] != 0.0, axis=1)
        numbers = np.arange(found, found + len(table))
        found += len(table)
        tables.append(table[echo])
        cells.append(numbers[echo])
        empty.append(numbers[~echo])
    warnings = _refuse_short(path, part, found, options)
    keep = slice(None, None, options.every_nth)
    return _build_scan(
        path,
        part,
        np.concatenate(tables)[keep],
        _build_grid(part.header.cut(found), _join(cells)[keep], _join(empty)),
        warnings,
    )


def _join(parts: list[AnyArray]) -> AnyArray:
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


def _parse_cells(
    path: Path, reader: LineReader, block: bytes, width: int, options: ReadOptions
) -> Floats:
    parsed = parse_block(block, ["f8"] * width, None)
    lines = block.count(b"\n") + (not block.endswith(b"\n"))
    at_end = reader.bytes_left == 0 and options.recover
    if len(parsed) < lines and not (at_end and parsed.bad in ([], [lines - 1])):
        first = parsed.bad[0] + 1 if parsed.bad else 0
        where = reader.lines_read - lines + first
        raise BadInput(
            f"{path.name}, line {where}: {parsed.first_bad or 'an empty line'!r} is no cell"
            f" of {width} numbers.",
            "The file is damaged here.",
        )
    return np.column_stack(parsed.columns)


def _build_grid(header: ScanHeader, cells: AnyArray, empty: AnyArray) -> Grid:
    column, row = np.divmod(cells, header.rows)
    empty_column, empty_row = np.divmod(empty, header.rows)
    return Grid(
        rows=header.rows,
        columns=header.columns,
        row=row.astype(np.int32),
        column=column.astype(np.int32),
        no_return=empty_row * header.columns + empty_column,
    )


def _build_scan(
    path: Path, part: _Part, table: Floats, grid: Grid, warnings: tuple[str, ...]
) -> Scan:
    attributes = {
        name: _narrow_colour(name, table[:, 3 + i].copy())
        for i, name in enumerate(_ATTRIBUTES[part.width])
    }
    xyz = part.header.to_world(table[:, :3])
    pose, doubts = part.header.pose(xyz)
    return Scan(
        name=path.stem if part.index == 0 else f"{path.stem} {part.index + 1}",
        xyz=xyz,
        attributes=attributes,
        channels=recognise_channels(attributes),
        pose=pose,
        grid=grid,
        metadata={"format": NAME},
        warnings=warnings + doubts,
    )


def _narrow_colour(name: str, values: Floats) -> AnyArray:
    """Colours as bytes where they are whole numbers of a byte; anything else as it is."""
    if name == "intensity" or not np.all(
        (values >= 0) & (values <= 255) & (np.floor(values) == values)
    ):
        return values
    return values.astype(np.uint8)
