"""Lines of numbers to columns: numpy's parser first, a careful one where it objects."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray

Kind = Literal["f8", "i8", "u8", "text"]


@dataclass(frozen=True, slots=True, eq=False)
class Parsed:
    """Columns of a block, and which of its lines (zero-based) are no row of them."""

    columns: list[AnyArray]
    bad: list[int] = field(default_factory=list)
    first_bad: str = ""

    def __len__(self) -> int:
        return len(self.columns[0])


def parse_block(block: bytes, kinds: Sequence[Kind], separator: str | None) -> Parsed:
    """Columns of a block of lines.

    Parameters
    ----------
    block : bytes
        Whole lines. Blank lines count for nothing.
    kinds : sequence of {'f8', 'i8', 'u8', 'text'}
        What each column holds.
    separator : str or None
        One character, or None for any white space.

    Returns
    -------
    Parsed
        One array per column: numbers of its kind, or strings. An empty cell is NaN.
    """
    text = block.decode("latin-1")
    if not text.strip():
        return Parsed([_to_array([], kind) for kind in kinds])
    fast = None if "text" in kinds else _parse_fast(text, kinds, separator)
    return fast or _parse_carefully(block, kinds, separator)


def narrow(values: AnyArray, type_name: str) -> AnyArray:
    """Values in a declared type (``u1``, ``f4`` …); as they are where they do not fit it."""
    if type_name in ("f4", "f8"):
        with np.errstate(over="ignore"):
            return values.astype(type_name)
    limits = np.iinfo(type_name)
    fits = np.all((values >= limits.min) & (values <= limits.max) & (np.floor(values) == values))
    return values.astype(type_name) if fits else values


def kind_of(type_name: str) -> Kind:
    """What to parse for a declared type: a double would round 64-bit integers."""
    exact: dict[str, Kind] = {"i8": "i8", "u8": "u8"}
    return exact.get(type_name, "f8")


def _parse_fast(text: str, kinds: Sequence[Kind], separator: str | None) -> Parsed | None:
    dtype = "f8"
    if any(kind != "f8" for kind in kinds):
        dtype = np.dtype([(f"c{i}", kind) for i, kind in enumerate(kinds)])  # type: ignore[assignment]
    try:
        table = np.loadtxt(
            io.StringIO(text), dtype=dtype, delimiter=separator, comments=None, ndmin=2
        )
    except (ValueError, OverflowError):
        return None
    if table.dtype.names:
        return Parsed([table[name].ravel() for name in table.dtype.names])
    if table.shape[1] != len(kinds):
        return None
    return Parsed(list(table.T))


def _parse_carefully(block: bytes, kinds: Sequence[Kind], separator: str | None) -> Parsed:
    rows: list[list[float | int | str]] = []
    bad: list[int] = []
    first_bad = ""
    for index, line in enumerate(_split_lines(block)):
        if not line.strip():
            continue
        try:
            rows.append(_convert(split_cells(line, separator), kinds))
        except (ValueError, OverflowError):
            first_bad = first_bad or line[:80].strip()
            bad.append(index)
    cells = zip(*rows, strict=True) if rows else ([] for _ in kinds)
    columns = [_to_array(list(c), kind) for c, kind in zip(cells, kinds, strict=True)]
    return Parsed(columns, bad, first_bad)


def _split_lines(block: bytes) -> list[str]:
    try:
        text = block.decode("utf-8")
    except UnicodeDecodeError:
        text = block.decode("latin-1")
    return text.split("\n")


def split_cells(line: str, separator: str | None) -> list[str]:
    """Cells of one line, without quotes and the space around them."""
    if '"' in line:
        cells = _split_quoted(line.strip("\r\n"), separator)
    else:
        cells = line.strip("\r\n").split(separator)
    cells = [cell.strip() for cell in cells]
    return cells if separator else [cell for cell in cells if cell]


def _split_quoted(line: str, separator: str | None) -> list[str]:
    if separator is None:
        line, separator = line.replace("\t", " "), " "
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise ValueError(str(error)) from error


def to_number(cell: str) -> float:
    """Number of a cell, NaN where it is empty; `ValueError` where it is neither."""
    if not cell:
        return float("nan")
    if "_" in cell or not cell.isascii():  # Python reads 1_000 and other scripts' digits
        raise ValueError(cell)
    return float(cell)


def _convert(cells: list[str], kinds: Sequence[Kind]) -> list[float | int | str]:
    if len(cells) == len(kinds) + 1 and not cells[-1]:  # a separator at the end of the line
        cells = cells[:-1]
    return [_convert_cell(cell, kind) for cell, kind in zip(cells, kinds, strict=True)]


def _convert_cell(cell: str, kind: Kind) -> float | int | str:
    if kind == "text":
        return cell
    number = to_number(cell)
    if kind == "f8":
        return number
    exact = int(cell) if cell.lstrip("+-").isdigit() else int(number)
    low, high = (0, 2**64) if kind == "u8" else (-(2**63), 2**63)
    if not low <= exact < high or (exact != number and abs(number) < 2.0**53):
        raise ValueError(cell)
    return exact


def _to_array(cells: list[float | int | str], kind: Kind) -> AnyArray:
    return np.array(cells, dtype=str if kind == "text" else kind)
