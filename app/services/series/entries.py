"""What the scans of a series are: angle, time, treatment, from names, a table, or typed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from app.core.errors import BadInput, WrongUse
from app.services.panel_columns import read_header
from app.services.tables import Table, read_table

COLUMNS = {
    "file": ("file", "filename", "file_name", "path", "scan"),
    "angle": ("angle", "angle_deg", "holder_angle", "holder_angle_deg", "deg"),
    "hours": ("hours", "time_h", "h"),
    "time": ("time", "timestamp", "datetime", "date"),
    "treatment": ("treatment", "group"),
    "label": ("label", "name", "comment"),
    "key": ("key",),
    "value": ("value",),
}
"""Names by which a column is known; key and value are those of a simulated series."""
VALUES = ("angle", "hours")
TITLES = {"angle": "angle (deg)", "hours": "time (h)"}


@dataclass(frozen=True, slots=True)
class Entry:
    """A file of a series, and what was different when it was scanned.

    Attributes
    ----------
    file : Path
    angle_deg : float or None
        Of the holder.
    hours : float or None
    moment : datetime or None
        When it was scanned; `hours` are counted from the first of the series.
    treatment, label : str
    """

    file: Path
    angle_deg: float | None = None
    hours: float | None = None
    moment: datetime | None = None
    treatment: str = ""
    label: str = ""


@dataclass(frozen=True, slots=True)
class Understood:
    """Entries, and in a sentence how they were understood."""

    entries: tuple[Entry, ...]
    how: str

    @property
    def turns(self) -> bool:
        """Whether the holder stood at more than one angle."""
        return len({entry.angle_deg for entry in self.entries} - {None}) > 1


def count_hours(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """Entries with their hours counted from the earliest moment, where they have moments."""
    moments = [entry.moment for entry in entries if entry.moment is not None]
    if not moments:
        return tuple(entries)
    if len({moment.tzinfo is None for moment in moments}) > 1:
        raise BadInput("Some times have a time zone and others have none.", "Write all alike.")
    first = min(moments)
    return tuple(
        entry
        if entry.moment is None
        else replace(entry, hours=(entry.moment - first).total_seconds() / 3600.0)
        for entry in entries
    )


def type_entries(files: Sequence[Path], text: str, role: str) -> Understood:
    """Entries whose values were typed, in the order of the files: ``0,5,10``.

    Raises
    ------
    WrongUse
        Not numbers, or not as many as files.
    """
    try:
        values = [parse_number(piece) for piece in text.split(",")]
    except ValueError as error:
        raise WrongUse(f"{text!r} is not a list of numbers with commas between.") from error
    if len(values) != len(files):
        raise WrongUse(f"There are {len(files)} scans and {len(values)} values.")
    entries = tuple(
        set_value(Entry(file), role, value) for file, value in zip(files, values, strict=True)
    )
    return Understood(entries, f"{TITLES[role]} as typed")


def set_value(entry: Entry, role: str, value: float) -> Entry:
    """The entry with its angle or its hours."""
    if role == "angle":
        return replace(entry, angle_deg=value)
    return replace(entry, hours=value)


def read_entries(files: Sequence[Path], table: Path) -> Understood:
    """Entries as a table says; files that it does not name are left as they are.

    Parameters
    ----------
    files : sequence of Path
    table : Path
        CSV with a column for the file (its name, or its path from the table) and at least one
        of those in `COLUMNS`.

    Raises
    ------
    BadInput
        The table cannot be read, has no such columns, names a file twice, or lacks a file.
    """
    header = read_header(table)
    roles = {role: name for role, names in COLUMNS.items() if (name := _find(header, names))}
    if "file" not in roles or len(roles) < 2:
        raise BadInput(
            f"{table.name} must have a column file, and one of angle, hours, time, treatment or "
            "label.",
            f"Its columns: {', '.join(header) or 'none'}.",
        )
    held = read_table(table, list(roles.values()))
    rows = _rows_by_name(held, roles["file"])
    missing = [file.name for file in files if file.name.casefold() not in rows]
    if missing:
        raise BadInput(
            f"{table.name} has no row for {missing[0]}"
            + (f" and {len(missing) - 1} others." if len(missing) > 1 else "."),
            "Name files as they are called, with what follows the dot.",
        )
    entries = [_entry(file, held, roles, rows[file.name.casefold()]) for file in files]
    told = [role for role in roles if role != "file"]
    return Understood(count_hours(entries), f"{', '.join(told)} from {table.name}")


def _find(header: Sequence[str], names: Sequence[str]) -> str | None:
    return next((cell for name in names for cell in header if cell.casefold() == name), None)


def _rows_by_name(table: Table, column: str) -> dict[str, int]:
    rows: dict[str, int] = {}
    for row, cell in enumerate(table.columns[column]):
        name = cell.replace("\\", "/").rpartition("/")[2].casefold()
        if name in rows:
            raise BadInput(f"{table.name}, row {table.lines[row]}: {cell} is named twice.")
        rows[name] = row
    return rows


def _entry(file: Path, table: Table, roles: dict[str, str], row: int) -> Entry:
    cells = {role: table.columns[name][row] for role, name in roles.items()}
    where = f"{table.name}, row {table.lines[row]}"
    if "key" in cells and "value" in cells:
        cells.setdefault(_role_of_key(cells["key"]), cells["value"])
    entry = Entry(file, treatment=cells.get("treatment", ""), label=cells.get("label", ""))
    for role in VALUES:
        if cells.get(role):
            entry = set_value(entry, role, _number(cells[role], where, roles.get(role, "value")))
    return set_time(entry, cells["time"], where) if cells.get("time") else entry


def _role_of_key(key: str) -> str:
    """Role of a value that was varied: an angle, hours, or a mere label."""
    last = key.rpartition(".")[2].casefold()
    return "angle" if last.endswith("angle_deg") else "hours" if last == "hours" else "label"


def _number(cell: str, where: str, column: str) -> float:
    try:
        return parse_number(cell)
    except ValueError as error:
        raise BadInput(f"{where}: {cell[:40]!r} in column {column} is not a number.") from error


def parse_number(text: str) -> float:
    """A finite number, with a decimal point or comma; raises `ValueError`.

    Tables keep spreadsheets from running text by an apostrophe: ``'-30``.
    """
    value = float(text.strip().removeprefix("'").replace(",", ".").replace("−", "-"))
    if not math.isfinite(value) or "_" in text:
        raise ValueError(text)
    return value


def set_time(entry: Entry, text: str, where: str) -> Entry:
    """The entry with hours, or a moment as ISO 8601; raises `BadInput` for anything else."""
    try:
        return replace(entry, hours=parse_number(text))
    except ValueError:
        pass
    try:
        return replace(entry, moment=datetime.fromisoformat(text.strip()))
    except ValueError as error:
        raise BadInput(
            f"{where}: {text[:40]!r} is neither hours nor a time.",
            "Write hours as a number, or times as 2024-05-01T10:30.",
        ) from error
