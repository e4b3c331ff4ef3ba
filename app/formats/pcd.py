"""PCD of the Point Cloud Library: ascii, binary and compressed; all fields are kept."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.binary_rows import read_rows
from app.formats.channels import recognise_channels
from app.formats.cloud import take_points
from app.formats.header import Header
from app.formats.line_blocks import LineReader
from app.formats.lzf import decompress_lzf
from app.formats.number_lines import kind_of, narrow, parse_block
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.pcd_header import PADDING, PcdHeader, read_pcd_header
from app.formats.sidecar import restore_sidecar
from app.model.scan import Grid, Scan

NAME = "PCD"
SUFFIXES = (".pcd",)
MOST_COMPRESSED = 300  # LZF: 264 bytes of three


def matches(head: bytes, path: Path) -> bool:
    """The comment ``# .PCD``, or a line ``VERSION`` before a line ``FIELDS``; or the suffix."""
    begins = head.startswith(b"# .PCD") or (head.startswith(b"VERSION") and b"\nFIELDS" in head)
    return begins or path.suffix.lower() in SUFFIXES


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:
    """Check the header and its counts against the size of the file.

    Raises
    ------
    BadInput
        The header is damaged, or the file is shorter than it claims
        (unless `options.recover`).
    """
    header = read_pcd_header(path)
    points, warnings = _check_size(path, header, options)
    columns = sum(field.count for field in header.fields)
    return Header(
        points=points,
        attributes=tuple(f.name for f in header.fields if f.name.lower() not in ("x", "y", "z")),
        memory=points * 8 * (columns + 3) * 2,
        details={"encoding": header.encoding, "table": f"{header.width} × {header.height}"},
        warnings=warnings,
    )


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read all points; coordinates become float64, the rest keeps its type.

    Raises
    ------
    BadInput
        As `preflight`, and for a line that is no point or damaged compressed data.
    """
    header = read_pcd_header(path)
    points, warnings = _check_size(path, header, options)
    if header.encoding == "ascii":
        columns = _read_ascii(path, header, options, progress)
    elif header.encoding == "binary":
        columns = _read_binary(path, header, points, progress)
    else:
        columns = _read_compressed(path, header, progress)
    found = len(columns[0])
    if found < header.points:
        if not options.recover:
            raise _too_short(path, header)
        warnings = (_describe_missing(header, found),)
    named = _name_columns(header, columns)
    axes = {name.lower(): name for name in named if name.lower() in ("x", "y", "z")}
    scan = Scan(
        name=path.stem,
        xyz=np.column_stack([named.pop(axes[axis]).astype(np.float64) for axis in "xyz"]),
        attributes=named,
        channels=recognise_channels(named),
        pose=header.pose,
        grid=_build_grid(header, found),
        metadata={"format": NAME},
        warnings=warnings,
    )
    if options.every_nth > 1:
        scan = take_points(scan, np.arange(0, found, options.every_nth))
    return [restore_sidecar(path, scan)]


def _check_size(path: Path, header: PcdHeader, options: ReadOptions) -> tuple[int, tuple[str, ...]]:
    """Points that the file can hold; see `preflight` for the error."""
    left = path.stat().st_size - header.offset
    if header.encoding == "ascii":
        there = (left + 1) // (2 * sum(field.count for field in header.fields))
    elif header.encoding == "binary":
        there = left // header.row_type.itemsize
    else:
        there = left * MOST_COMPRESSED // header.row_type.itemsize
    if there >= header.points:
        return header.points, ()
    if not options.recover or header.encoding == "binary_compressed":
        raise _too_short(path, header)
    return max(there, 0), (_describe_missing(header, max(there, 0)),)


def _too_short(path: Path, header: PcdHeader) -> BadInput:
    return BadInput(
        f"{path.name} claims {header.points} points and is too short for them.",
        "The file is cut or damaged; --recover reads the complete points of one that is"
        " not compressed.",
    )


def _describe_missing(header: PcdHeader, found: int) -> str:
    return f"The file ends early: {header.points - found} of {header.points} points missing."


def _read_ascii(
    path: Path, header: PcdHeader, options: ReadOptions, progress: Progress
) -> list[AnyArray]:
    # Coordinates as written, whatever type is declared: a float would lose digits of UTM.
    types = [
        "f8" if field.name.lower() in ("x", "y", "z") else field.type
        for field in header.fields
        for _ in range(field.count)
    ]
    parts = [[np.empty(0, kind_of(item))] for item in types]
    with LineReader(path, header.offset) as reader:
        for columns in _parse_points(path, header, reader, options, types):
            progress.report(reader.fraction, f"Reading {path.name}")
            for part, column in zip(parts, columns, strict=True):
                part.append(column)
    table = [np.concatenate(part) for part in parts]
    columns, start = [], 0
    for field in header.fields:
        values = np.column_stack(table[start : start + field.count])
        columns.append(narrow(values, types[start]))
        start += field.count
    return columns


def _parse_points(
    path: Path, header: PcdHeader, reader: LineReader, options: ReadOptions, types: list[str]
) -> Iterator[list[AnyArray]]:
    first = reader.peek() or ""
    separator = next((mark for mark in ",;" if mark in first), None)
    for block in reader.blocks(header.points):
        parsed = parse_block(block, [kind_of(item) for item in types], separator)
        lines = block.count(b"\n") + (not block.endswith(b"\n"))
        cut_line = parsed.bad == [lines - 1] and reader.bytes_left == 0 and options.recover
        if parsed.bad and not cut_line:
            number = header.lines + reader.lines_read - lines + parsed.bad[0] + 1
            raise BadInput(
                f"{path.name}, line {number}: {parsed.first_bad!r} is no point of"
                f" {len(types)} numbers.",
                "The file is damaged here.",
            )
        yield parsed.columns


def _read_binary(path: Path, header: PcdHeader, points: int, progress: Progress) -> list[AnyArray]:
    with path.open("rb") as file:
        file.seek(header.offset)
        table, _ = read_rows(file, header.row_type, points, 1, progress)
    return [np.ascontiguousarray(table[name]) for name in table.dtype.names or ()]


def _read_compressed(path: Path, header: PcdHeader, progress: Progress) -> list[AnyArray]:
    """Decompress; the fields follow one another, each with the values of all points."""
    with path.open("rb") as file:
        file.seek(header.offset)
        sizes = np.frombuffer(file.read(8).ljust(8, b"\0"), "<u4")
        packed, size = int(sizes[0]), int(sizes[1])
        data = file.read(packed)
    if len(data) < packed or size != header.points * header.row_type.itemsize:
        raise _too_short(path, header)
    values = decompress_lzf(data, size, progress)
    columns, offset = [], 0
    for field in header.fields:
        count = header.points * field.count
        column = np.frombuffer(values, f"<{field.type}", count, offset)
        columns.append(column.reshape(-1, field.count))
        offset += column.nbytes
    return columns


def _name_columns(header: PcdHeader, tables: list[AnyArray]) -> dict[str, AnyArray]:
    """Columns by name: ``name``, or ``name_0``, ``name_1`` … for several values per point."""
    named = {}
    for field, table in zip(header.fields, tables, strict=True):
        if field.name == PADDING:
            continue
        for index in range(field.count):
            name = field.name if field.count == 1 else f"{field.name}_{index}"
            named[name] = table[:, index].copy()
    return named


def _build_grid(header: PcdHeader, points: int) -> Grid | None:
    """The table of an organised cloud: `height` rows, one after the other."""
    if header.height < 2 or points < header.points:
        return None
    row, column = np.divmod(np.arange(points), header.width)
    return Grid(header.height, header.width, row.astype(np.int32), column.astype(np.int32))
