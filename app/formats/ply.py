"""PLY, ascii and both binaries: all vertex properties; faces and other elements are skipped."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.binary_rows import read_rows
from app.formats.channels import recognise_channels
from app.formats.header import Header
from app.formats.line_blocks import LineReader
from app.formats.number_lines import kind_of, narrow, parse_block
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.ply_comments import original_names, pose_of_comments
from app.formats.ply_header import Element, PlyHeader, Property, read_ply_header
from app.formats.ply_writer import write
from app.formats.sidecar import restore_sidecar
from app.model.scan import Scan

__all__ = ["NAME", "SUFFIXES", "matches", "preflight", "read", "write"]

NAME = "PLY"
SUFFIXES = (".ply",)


def matches(head: bytes, path: Path) -> bool:  # noqa: ARG001 (the magic decides)
    """The word ``ply`` on the first line."""
    return head[:3] == b"ply" and head[3:4] in (b"\n", b"\r", b" ", b"\t", b"")


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:
    """Check the header and its counts against the size of the file.

    Raises
    ------
    BadInput
        The header is damaged, or the file is shorter than it claims
        (unless `options.recover`).
    """
    header = read_ply_header(path)
    points, warnings = _check_size(path, header, options)
    width = len(header.vertex.properties)
    return Header(
        points=points,
        attributes=tuple(p.name for p in header.vertex.properties if p.name.lower() not in "xyz"),
        memory=points * 8 * (width + 3) * 2,
        details={"encoding": header.encoding, "comments": "; ".join(header.comments)[:1000]},
        warnings=warnings,
    )


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read the vertices; coordinates become float64, the rest keeps its type.

    Raises
    ------
    BadInput
        As `preflight`, and for a line of an ascii file that is no vertex.
    """
    header = read_ply_header(path)
    points, warnings = _check_size(path, header, options)
    if header.encoding == "ascii":
        columns, missing = _read_ascii(path, header, options, progress)
    else:
        columns, missing = _read_binary(path, header, points, options, progress)
    if missing:
        warnings = (f"The file ends early: {missing} of {header.vertex.count} points missing.",)
    named = {p.name: values for p, values in zip(header.vertex.properties, columns, strict=True)}
    axes = {name.lower(): name for name in named if name.lower() in ("x", "y", "z")}
    xyz = np.column_stack([named.pop(axes[axis]).astype(np.float64) for axis in "xyz"])
    names = original_names(header.comments)
    named = {names.get(name, name): values for name, values in named.items()}
    scan = Scan(
        name=path.stem,
        xyz=xyz,
        attributes=named,
        channels=recognise_channels(named),
        pose=pose_of_comments(header.comments),
        metadata={"format": NAME, "comments": "\n".join(header.comments)[: 1 << 20]},
        warnings=warnings,
    )
    return [restore_sidecar(path, scan)]


def _check_size(path: Path, header: PlyHeader, options: ReadOptions) -> tuple[int, tuple[str, ...]]:
    """Points that the file can hold; see `preflight` for the error."""
    left = path.stat().st_size - header.offset
    for element in header.before_vertex:
        left -= element.count * element.smallest_row(header.encoding)
    claimed, row = header.vertex.count, header.vertex.smallest_row(header.encoding)
    separators = claimed - 1 if header.encoding == "ascii" else 0
    if claimed * row + max(separators, 0) <= left:
        return claimed, ()
    if not options.recover:
        raise _too_short(path, claimed)
    there = min(claimed, max(left, 0) // row)
    return there, (f"The file ends early: {claimed - there} of {claimed} points missing.",)


def _too_short(path: Path, claimed: int) -> BadInput:
    return BadInput(
        f"{path.name} claims {claimed} points and is too short for them.",
        "The file is cut or damaged; --recover reads the complete points.",
    )


def _read_ascii(
    path: Path, header: PlyHeader, options: ReadOptions, progress: Progress
) -> tuple[list[AnyArray], int]:
    # Coordinates as written, whatever type is declared: a float would lose digits of UTM.
    types = [
        "f8" if p.name.lower() in ("x", "y", "z") else p.type for p in header.vertex.properties
    ]
    parts: list[list[AnyArray]] = [[] for _ in types]
    found = 0
    with LineReader(path, header.offset) as reader:
        for element in header.before_vertex:
            for _ in reader.blocks(element.count):
                progress.report(reader.fraction, f"Reading {path.name}")
        for columns in _parse_vertices(path, header, reader, options, types):
            progress.report(reader.fraction, f"Reading {path.name}")
            first = -found % options.every_nth
            found += len(columns[0])
            for part, column in zip(parts, columns, strict=True):
                part.append(column[first :: options.every_nth])
    missing = header.vertex.count - found
    if missing and not options.recover:
        raise _too_short(path, header.vertex.count)
    empty = [np.empty(0, item) for item in types]
    return [np.concatenate([e, *p]) for e, p in zip(empty, parts, strict=True)], missing


def _parse_vertices(
    path: Path, header: PlyHeader, reader: LineReader, options: ReadOptions, types: list[str]
) -> Iterator[list[AnyArray]]:
    kinds = [kind_of(item) for item in types]
    for block in reader.blocks(header.vertex.count):
        parsed = parse_block(block, kinds, None)
        lines = block.count(b"\n") + (not block.endswith(b"\n"))
        cut_line = parsed.bad == [lines - 1] and reader.bytes_left == 0 and options.recover
        if parsed.bad and not cut_line:
            number = header.lines + reader.lines_read - lines + parsed.bad[0] + 1
            raise _bad_vertex(path, number, parsed.first_bad, len(kinds))
        yield [narrow(c, t) for c, t in zip(parsed.columns, types, strict=True)]


def _bad_vertex(path: Path, number: int, text: str, width: int) -> BadInput:
    return BadInput(
        f"{path.name}, line {number}: {text!r} is no vertex of {width} numbers.",
        "The file is damaged here.",
    )


def _read_binary(
    path: Path, header: PlyHeader, points: int, options: ReadOptions, progress: Progress
) -> tuple[list[AnyArray], int]:
    dtype = header.vertex.row_type(header.encoding)
    with path.open("rb") as file:
        file.seek(header.offset)
        for element in header.before_vertex:
            _skip_binary(path, file, element, header, progress)
        table, found = read_rows(file, dtype, points, options.every_nth, progress)
    missing = header.vertex.count - found
    if missing and not options.recover:
        raise _too_short(path, header.vertex.count)
    return [
        table[name].astype(p.type)
        for name, p in zip(dtype.names or (), header.vertex.properties, strict=True)
    ], missing


def _skip_binary(
    path: Path, file: BinaryIO, element: Element, header: PlyHeader, progress: Progress
) -> None:
    if not element.has_lists:
        file.seek(element.count * element.smallest_row(header.encoding), os.SEEK_CUR)
        return
    order = ">" if header.encoding == "binary_big_endian" else "<"
    size = path.stat().st_size
    for row in range(element.count):
        if row % 10_000 == 0:
            progress.report(0.0, f"Reading {path.name}")
        for item in element.properties:
            length = _read_length(file, order, item)
            if length is None:
                raise _too_short(path, header.vertex.count)
            if not 0 <= length <= size:
                raise BadInput(f"{path.name}: a list of {element.name} has {length} items.")
            file.seek(length * np.dtype(item.type).itemsize, os.SEEK_CUR)


def _read_length(file: BinaryIO, order: str, item: Property) -> int | None:
    """Items of a list, 1 where it is none; None at the end of the file."""
    if item.length_type is None:
        return 1
    dtype = np.dtype(order + item.length_type)
    data = file.read(dtype.itemsize)
    if len(data) < dtype.itemsize or dtype.kind == "f":
        return None
    return int(np.frombuffer(data, dtype)[0])
