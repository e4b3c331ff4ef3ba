"""Writer of CSV: one line of names, then one row per point; numbers come back bit by bit."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from app.core.arrays import AnyArray
from app.core.errors import BadInput
from app.core.progress import Progress
from app.formats.cloud import Cloud
from app.formats.column_names import give_file_names

NAME = "CSV"
SUFFIXES = (".csv", ".txt", ".xyz")
_ROWS = 20_000
_FORMULA = ("=", "+", "-", "@")


def write(path: Path, cloud: Cloud, progress: Progress) -> None:
    """Write a cloud with commas and decimal points, in UTF-8.

    Every float has the fewest digits that give the same float again; booleans are 0 and 1.
    The units are in the sidecar (`saving.save`).

    Raises
    ------
    BadInput
        A column holds neither numbers nor booleans.
    """
    columns = cloud.columns
    for name, values in columns.items():
        if values.dtype.kind not in "biuf":
            raise BadInput(f"{name} holds {values.dtype}, which is no number.")
    names = give_file_names(columns, taken=("x", "y", "z"), clean=_clean)
    table = [*cloud.scan.xyz.T, *columns.values()]
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(_make_line(["x", "y", "z", *names.values()]))
        for start in range(0, len(cloud.scan), _ROWS):
            progress.report(start / len(cloud.scan), "Writing CSV")
            cells = [_to_text(values[start : start + _ROWS]) for values in table]
            file.writelines(",".join(row) + "\n" for row in zip(*cells, strict=True))


def _to_text(values: AnyArray) -> Sequence[str]:
    if values.dtype.kind == "b":
        return ["1" if value else "0" for value in values.tolist()]
    if values.dtype.kind == "f" and values.dtype.itemsize < 8:
        return [str(value) for value in values]  # numpy's own: shortest for float32
    return list(map(repr, values.astype(values.dtype.newbyteorder("="), copy=False).tolist()))


def _make_line(names: Sequence[str]) -> str:
    """A line of names; one that a spreadsheet would take for a formula gets an apostrophe."""
    guarded = [f"'{name}" if name.startswith(_FORMULA) else name for name in names]
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(guarded)
    return line.getvalue()


def _clean(name: str) -> str:
    """A name that the text reader gives back: it takes quotes and ``-`` for something else."""
    kept = "".join(c if c.isprintable() else "_" for c in name).strip().lstrip("'")
    return "_" if kept == "-" else kept.replace('"', "")
