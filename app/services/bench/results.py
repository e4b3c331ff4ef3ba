"""What a bench finds: tables of named values, and the files that they become."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.core.errors import BadInput
from app.formats.atomic import atomic_files, refuse_targets
from app.services.bench.machine import describe_machine

Value = float | int | str | bool
Draw = Callable[[Path], None]


@dataclass(frozen=True, slots=True)
class ResultTable:
    """Rows of named values; all rows have the same names.

    Attributes
    ----------
    name : str
        Stem of the file that the table becomes.
    title : str
    rows : sequence of mappings
    note : str
        What a reader must know to understand it.
    """

    name: str
    title: str
    rows: Sequence[Mapping[str, Value]]
    note: str = ""

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the values."""
        return tuple(self.rows[0]) if self.rows else ()


@dataclass(frozen=True, slots=True)
class Bench:
    """All that a bench found.

    Attributes
    ----------
    name : str
        Stem of its JSON file.
    tables : tuple of ResultTable
    pictures : mapping of str to callable
        By stem; each draws a PNG at a path.
    """

    name: str
    tables: tuple[ResultTable, ...]
    pictures: Mapping[str, Draw]

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON, with the facts of the machine."""
        tables = {
            table.name: {"title": table.title, "note": table.note, "rows": list(table.rows)}
            for table in self.tables
        }
        return {"bench": self.name, "machine": describe_machine(), "tables": tables}


def list_targets(
    out: Path, name: str, tables: Sequence[str], pictures: Sequence[str]
) -> list[Path]:
    """The files that a bench writes into a folder."""
    names = [f"{name}.json", *(f"{stem}.csv" for stem in tables), *(f"{p}.png" for p in pictures)]
    return [out / file for file in names]


def write_bench(bench: Bench, out: Path, overwrite: bool = False) -> list[Path]:
    """Write tables as CSV, everything as JSON and the pictures: all of them, or nothing.

    Raises
    ------
    BadInput
        A file exists and may not be replaced, or cannot be written.
    """
    targets = list_targets(out, bench.name, [t.name for t in bench.tables], list(bench.pictures))
    refuse_targets(targets, overwrite, folder_follows=True)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"The folder {out} cannot be made: {error.strerror or error}.") from error
    with atomic_files() as begin:
        whole, *rest = (begin(target, overwrite) for target in targets)
        whole.write_text(json.dumps(_plain(bench.as_dict()), indent=1, ensure_ascii=False))
        writers = [*(_writer(table) for table in bench.tables), *bench.pictures.values()]
        for write, path in zip(writers, rest, strict=True):
            write(path)
    return targets


def _writer(table: ResultTable) -> Draw:
    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            lines = csv.DictWriter(file, table.columns, lineterminator="\n")
            lines.writeheader()
            lines.writerows(table.rows)

    return write


def _plain(value: Any) -> Any:
    """The value as JSON can hold it: NaN and infinity become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
