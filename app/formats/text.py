"""Text with columns: XYZ, CSV, TXT, PTS, ASC. The layout is guessed and can be corrected."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.channels import recognise_channels
from app.formats.header import Header
from app.formats.line_blocks import LineReader, count_lines
from app.formats.number_lines import Kind, Parsed, kind_of, parse_block
from app.formats.options import DEFAULTS, ReadOptions
from app.formats.sidecar import Sidecar, apply_sidecar, find_sidecar
from app.formats.text_layout import TextLayout, find_layout
from app.model.scan import Scan

NAME = "text"
SUFFIXES = (".xyz", ".csv", ".txt", ".pts", ".asc")


def matches(head: bytes, path: Path) -> bool:  # noqa: ARG001 (text has no magic)
    """The suffix; `find_layout` says what is wrong with a file that is no text."""
    return path.suffix.lower() in SUFFIXES


def preflight(path: Path, options: ReadOptions = DEFAULTS) -> Header:
    """Guess the layout and count the lines.

    Raises
    ------
    BadInput
        The layout cannot be told; see `find_layout`.
    """
    layout = find_layout(path, options)
    points = max(count_lines(path) - layout.header_lines, 0)
    names = [name for i, name in enumerate(layout.columns) if i not in layout.axes and name != "-"]
    return Header(
        points=points,
        attributes=tuple(names),
        memory=points * 8 * (len(layout.columns) + 3) * 2,
        details=layout.describe(),
        warnings=layout.warnings,
    )


def read(path: Path, options: ReadOptions, progress: Progress) -> list[Scan]:
    """Read all rows; those with another number of cells are left out and counted.

    A column of words becomes whole numbers, and the words are listed in the metadata.

    Raises
    ------
    BadInput
        The layout cannot be told, or more rows are left out than read.
    """
    layout = find_layout(path, options)
    sidecar, stale = find_sidecar(path)
    if sidecar is not None and options.columns is None:
        layout = _name_back(layout, sidecar)
    table = _Table(layout, _widen_kinds(layout, sidecar))
    with LineReader(path) as reader:
        for _ in reader.blocks(layout.header_lines):
            pass
        for parsed, line in _parse(reader, layout, table.kinds):
            progress.report(reader.fraction, f"Reading {path.name}")
            table.add(parsed, line, options.every_nth)
    _refuse_ragged(path, table)
    scan = _build_scan(path, layout, table, stale)
    return [scan if sidecar is None else apply_sidecar(scan, sidecar)]


@dataclass(slots=True, eq=False)
class _Table:
    """The rows read so far."""

    layout: TextLayout
    kinds: tuple[Kind, ...]
    parts: list[list[AnyArray]] = field(default_factory=list)
    words: list[dict[str, int]] = field(default_factory=list)
    rows: int = 0
    left_out: int = 0
    first_left_out: str = ""

    def __post_init__(self) -> None:
        self.parts = [[np.empty(0, "i8" if k == "text" else k)] for k in self.kinds]
        self.words = [{} for _ in self.kinds]

    def add(self, parsed: Parsed, line: int, every_nth: int) -> None:
        """Take the rows of a block whose first line is number `line`."""
        if parsed.bad and not self.left_out:
            self.first_left_out = f"line {line + parsed.bad[0]}: {parsed.first_bad!r}"
        self.left_out += len(parsed.bad)
        keep = slice(-self.rows % every_nth, None, every_nth)
        self.rows += len(parsed)
        for part, words, values in zip(self.parts, self.words, parsed.columns, strict=True):
            part.append(_number_words(values, words)[keep])

    def column(self, index: int) -> AnyArray:
        return np.concatenate(self.parts[index])


def _number_words(values: AnyArray, words: dict[str, int]) -> AnyArray:
    """Words as their numbers in order of appearance; numbers as they are."""
    if values.dtype.kind != "U":
        return values
    return np.array([words.setdefault(word, len(words)) for word in values.tolist()], np.int64)


def _name_back(layout: TextLayout, sidecar: Sidecar) -> TextLayout:
    """The names that our CSV writer had to change for the file; it keeps their order."""
    names = [name for name in sidecar.types if name.isprintable() and name != "-"]
    if layout.columns[:3] != ("x", "y", "z") or len(names) != len(layout.columns) - 3:
        return layout
    return replace(layout, columns=("x", "y", "z", *names))


def _widen_kinds(layout: TextLayout, sidecar: Sidecar | None) -> tuple[Kind, ...]:
    """Kinds of the columns; 64-bit integers are parsed as such, a double would round them."""
    types = {} if sidecar is None else sidecar.types
    exact = [kind_of(types.get(name, "")[1:]) for name in layout.columns]
    return tuple(e if e != "f8" else k for e, k in zip(exact, layout.kinds, strict=True))


def _parse(
    reader: LineReader, layout: TextLayout, kinds: tuple[Kind, ...]
) -> Iterator[tuple[Parsed, int]]:
    line = reader.lines_read + 1
    for block in reader.blocks():
        yield parse_block(block, kinds, layout.separator), line
        line = reader.lines_read + 1


def _refuse_ragged(path: Path, table: _Table) -> None:
    if table.left_out > table.rows:
        raise BadInput(
            f"{path.name}: {table.left_out} lines are no row of {len(table.kinds)} columns,"
            f" first {table.first_left_out}.",
            "Give --separator or --columns.",
        )


def _build_scan(path: Path, layout: TextLayout, table: _Table, warnings: tuple[str, ...]) -> Scan:
    axes = layout.axes
    attributes = {
        name: table.column(i)
        for i, name in enumerate(layout.columns)
        if i not in axes and name != "-"
    }
    legends = {
        f"words of {name}": "; ".join(f"{number} = {word}" for word, number in words.items())
        for name, words in zip(layout.columns, table.words, strict=True)
        if words and name != "-"
    }
    return Scan(
        name=path.stem,
        xyz=np.column_stack([table.column(i).astype(np.float64) for i in axes]),
        attributes=attributes,
        channels=recognise_channels(attributes),
        metadata={"format": NAME, **layout.describe(), **legends},
        warnings=(*layout.warnings, *_describe_faults(path, layout, table), *warnings),
    )


def _describe_faults(path: Path, layout: TextLayout, table: _Table) -> Iterator[str]:
    if table.left_out:
        yield (
            f"{path.name}: lines left out because they are no row of {len(table.kinds)}"
            f" columns: {table.left_out}; first {table.first_left_out}."
        )
    if layout.claimed is not None and layout.claimed != table.rows:
        yield f"{path.name} announces {layout.claimed} points and holds {table.rows}."
