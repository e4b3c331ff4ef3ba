"""Tables of named columns that a user typed or exported: CSV in any of its dialects."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from app.core.arrays import Floats
from app.core.errors import BadInput

SEPARATORS = (",", ";", "\t")
MISSING = frozenset({"na", "nan", "n/a", "-"})
"""Cells in small letters that say, beside empty ones, that a number is missing."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of a file as text, with the line that each row came from.

    Attributes
    ----------
    name : str
        The file, for messages.
    columns : mapping of str to tuple of str
        Only those that were asked for.
    lines : tuple of int
        Line in the file, counted from 1.
    decimal_comma : bool
        Numbers may have a decimal comma, because the separator is another character.
    """

    name: str
    columns: Mapping[str, tuple[str, ...]]
    lines: tuple[int, ...]
    decimal_comma: bool = False

    def __len__(self) -> int:
        return len(self.lines)

    def numbers(self, column: str, missing: Collection[str] = ()) -> Floats:
        """One column as numbers, (n,); NaN where a cell is empty or holds a word of `missing`.

        Raises
        ------
        BadInput
            A cell is no number; names the line.
        """
        cells = zip(self.columns[column], self.lines, strict=True)
        return np.array([
            np.nan if cell.lower() in missing else self._parse(column, cell, line)
            for cell, line in cells
        ])  # fmt: skip

    def _parse(self, column: str, cell: str, line: int) -> float:
        if not cell:
            return np.nan
        text = cell.replace(",", ".") if self.decimal_comma and "." not in cell else cell
        try:
            if "_" in text:
                raise ValueError("Python's digit groups are not numbers of a table")
            return float(text)
        except ValueError:
            raise BadInput(
                f"{self.name}, row {line}: {cell[:40]!r} in column {column} is not a number."
            ) from None


def read_table(path: str | Path, columns: Sequence[str]) -> Table:
    """Read some columns of a text table.

    The separator (comma, semicolon or tab) is the commonest in the first line. Quoted names,
    CRLF and a byte order mark are understood; empty lines are skipped.

    Raises
    ------
    BadInput
        The file is missing, not UTF-8 text or without rows, a column is missing or there twice,
        or a row has another number of cells than the header.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _read(path.name, file, tuple(dict.fromkeys(columns)))
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise BadInput(f"{path.name} is not UTF-8 text.", "Save it as UTF-8.") from error
    except csv.Error as error:
        raise BadInput(f"{path.name} is not a readable table: {error}.") from error


def _read(name: str, file: TextIO, columns: tuple[str, ...]) -> Table:
    separator = _guess_separator(file.readline())
    file.seek(0)
    rows = _walk_rows(csv.reader(file, delimiter=separator, strict=True))
    _, header = next(rows, (0, []))
    places = [_find_column(name, header, column) for column in columns]
    lines: list[int] = []
    cells: list[tuple[str, ...]] = []
    for line, row in rows:
        if len(row) != len(header):
            raise BadInput(
                f"{name}, row {line} has {len(row)} cells; the header has {len(header)}."
            )
        lines.append(line)
        cells.append(tuple(row[place] for place in places))
    if not lines:
        raise BadInput(f"{name} has no rows below its header.")
    by_column = dict(zip(columns, zip(*cells, strict=True), strict=True))
    return Table(name, by_column, tuple(lines), decimal_comma=separator != ",")


def _guess_separator(line: str) -> str:
    outside_quotes = "".join(line.split('"')[::2])
    return max(SEPARATORS, key=outside_quotes.count)


def _walk_rows(reader: Iterator[list[str]]) -> Iterator[tuple[int, list[str]]]:
    for row in reader:
        stripped = [cell.strip() for cell in row]
        if any(stripped):
            yield reader.line_num, stripped  # type: ignore[attr-defined]


def _find_column(name: str, header: list[str], column: str) -> int:
    if header.count(column) == 1:
        return header.index(column)
    there = ", ".join(header) or "none"
    how = "no column" if column not in header else "more than one column"
    raise BadInput(f"{name} has {how} {column!r}.", f"Its columns: {there}.")
