"""Tables of panels as people write them: columns by their usual names, one table per channel."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import BadInput, WrongUse
from app.core.radiometry.panels import PanelTable, make_table, to_fractions
from app.services.tables import SEPARATORS, Table, read_table

SYNONYMS: Mapping[str, tuple[str, ...]] = {
    "range": ("range", "range_m", "distance", "distance_m", "d", "r"),
    "dn": ("dn", "intensity", "number", "value"),
    "reflectance": ("reflectance", "rho", "ρ", "reflectance_percent"),
    "scan": ("scan", "scan_id", "station"),
    "panel": ("panel", "material", "target", "panel_id"),
    "channel": ("channel", "band"),
    "wavelength_nm": ("wavelength_nm", "wavelength", "nm", "lambda"),
    "dn_sigma": ("dn_sigma", "sigma_dn", "dn_sd", "intensity_sigma"),
    "reflectance_sigma": ("reflectance_sigma", "sigma_reflectance", "sigma_rho", "reflectance_sd"),
}
"""What a column may be called, whatever its case; the first is its role."""
NEEDED = ("range", "dn", "reflectance")


@dataclass(frozen=True, slots=True)
class TableOptions:
    """How a table of panels is understood.

    Attributes
    ----------
    columns : tuple of str
        Roles named by hand, ``ROLE=NAME``.
    channel : str or None
        Only this channel; for a table without such a column its name.
    wavelength_nm : float or None
        For a table without such a column.
    percent : bool
        Reflectances and their σ are percent.
    panel_sigma : float
        σ of a panel's reflectance as a share of it, where the table has none.
    usual_nm : float or None
        Wavelength of the instrument, where neither the table nor the user tells one.
    """

    columns: tuple[str, ...] = ()
    channel: str | None = None
    wavelength_nm: float | None = None
    percent: bool = False
    panel_sigma: float = 0.0
    usual_nm: float | None = None


PLAIN = TableOptions()


@dataclass(frozen=True, slots=True)
class PanelFile:
    """What a file holds: a table for each channel, and columns that nobody asked for."""

    tables: tuple[PanelTable, ...]
    ignored: tuple[str, ...]


def read_panels(path: str | Path, options: TableOptions = PLAIN) -> PanelFile:
    """Read a table of panels.

    Raises
    ------
    BadInput
        The file cannot be read, a column is missing or there twice, a cell is no number, or a
        channel has no wavelength or two.
    WrongUse
        An option does not fit the table.
    """
    path = Path(path)
    header = read_header(path)
    roles = find_roles(path.name, header, parse_columns(options.columns))
    table = read_table(path, list(roles.values()))
    if not 0.0 <= options.panel_sigma < 1.0:
        raise WrongUse(
            f"A σ of {options.panel_sigma:g} of a panel's reflectance is impossible.",
            "Give a share of it, such as 0.02.",
        )
    ignored = tuple(name for name in header if name not in roles.values())
    return PanelFile(tuple(_split(table, roles, options)), ignored)


def parse_columns(texts: Sequence[str]) -> dict[str, str]:
    """Columns named by hand, ``ROLE=NAME``; raises `WrongUse` for a role that does not exist."""
    named = {}
    for text in texts:
        role, equals, name = text.partition("=")
        if not equals or role not in SYNONYMS:
            raise WrongUse(
                f"{text!r} names no column.", f"Write ROLE=NAME; roles: {', '.join(SYNONYMS)}."
            )
        named[role] = name.strip()
    return named


def read_header(path: Path) -> list[str]:
    """Names of the columns of a text table; raises `BadInput` where it cannot be read."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            line = file.readline()
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise BadInput(f"{path.name} is not UTF-8 text.", "Save it as UTF-8.") from error
    separator = max(SEPARATORS, key=line.count)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def find_roles(name: str, header: Sequence[str], named: Mapping[str, str]) -> dict[str, str]:
    """Column of each role that the table has.

    Raises
    ------
    BadInput
        A needed column is missing, or two columns could be the same.
    """
    roles = dict(named)
    for role, synonyms in SYNONYMS.items():
        found = [each for each in header if each.lower() in synonyms]
        if role in roles or not found:
            continue
        if len(found) > 1:
            raise BadInput(
                f"{name} has two columns for the {role}: {found[0]} and {found[1]}.",
                f"Say which with --column {role}=NAME.",
            )
        roles[role] = found[0]
    missing = [role for role in NEEDED if role not in roles]
    if missing:
        there = ", ".join(filter(None, header)) or "none"
        raise BadInput(
            f"{name} has no column for the {missing[0]}; its columns: {there}.",
            f"Name it with --column {missing[0]}=NAME.",
        )
    return roles


def _split(table: Table, roles: Mapping[str, str], options: TableOptions) -> list[PanelTable]:
    """A table for each channel."""
    if "channel" not in roles:
        return [_build(table, roles, options, np.ones(len(table), bool), options.channel or "")]
    cells = np.array(table.columns[roles["channel"]], dtype=str)
    names = list(dict.fromkeys(cells.tolist()))
    if options.channel is not None:
        if options.channel not in names:
            raise WrongUse(
                f"{table.name} has no channel {options.channel}.", f"It has: {', '.join(names)}."
            )
        names = [options.channel]
    if len(names) > 1 and "wavelength_nm" not in roles and options.wavelength_nm is not None:
        raise WrongUse(
            f"{table.name} has the channels {', '.join(names)}, and one wavelength for all.",
            "Add a column wavelength_nm, or choose one with --channel and give --wavelength.",
        )
    return [_build(table, roles, options, cells == name, name) for name in names]


def _build(
    table: Table, roles: Mapping[str, str], options: TableOptions, rows: Bools, name: str
) -> PanelTable:
    numbers = {
        role: table.numbers(roles[role])[rows]
        for role in ("range", "dn", "reflectance", "dn_sigma", "reflectance_sigma")
        if role in roles
    }
    texts = {
        role: np.array(table.columns[roles[role]], dtype=str)[rows]
        for role in ("scan", "panel")
        if role in roles
    }
    rho = numbers["reflectance"]
    if "panel" in texts:
        named = zip(texts["panel"].tolist(), rho, strict=True)
        texts["panel"] = np.array([name.strip() or f"{value:g}" for name, value in named], str)
    made = make_table(
        numbers["range"],
        numbers["dn"],
        rho,
        _find_wavelength(table, roles, options, rows, name),
        scan=texts.get("scan"),
        panel=texts.get("panel"),
        channel=name,
        dn_sigma=numbers.get("dn_sigma"),
        reflectance_sigma=numbers.get("reflectance_sigma", options.panel_sigma * rho),
        lines=np.array(table.lines)[rows].tolist(),
    )
    return to_fractions(made) if options.percent else made


def _find_wavelength(
    table: Table,
    roles: Mapping[str, str],
    options: TableOptions,
    rows: Bools,
    name: str,
) -> float:
    where = f"channel {name} of {table.name}" if name else table.name
    start = where[:1].upper() + where[1:] if name else where
    found = np.unique(_read_wavelengths(table, roles)[rows])
    known = found[np.isfinite(found)]
    if len(known) > 1:
        raise BadInput(
            f"{start} has two wavelengths, {known[0]:g} and {known[1]:g} nm.",
            "Add a column channel, or correct one.",
        )
    given = options.wavelength_nm
    if len(known) and given is not None and abs(given - known[0]) > 1e-6:
        raise WrongUse(
            f"{start} says {known[0]:g} nm, not {given:g}.",
            "Leave --wavelength out.",
        )
    given = options.usual_nm if given is None else given
    if not len(known) and given is None:
        several = "channel" in roles and len(set(table.columns[roles["channel"]])) > 1
        raise BadInput(
            f"The wavelength of {where} is missing.",
            "Add a column wavelength_nm, or choose one with --channel and give --wavelength."
            if several and options.channel is None
            else "Give it with --wavelength NM.",
        )
    value = float(known[0]) if len(known) else float(given or 0.0)
    if not 100.0 <= value <= 20_000.0:
        raise BadInput(
            f"A wavelength of {value:g} nm is impossible for a scanner.", "Give nanometres."
        )
    return value


def _read_wavelengths(table: Table, roles: Mapping[str, str]) -> Floats:
    if "wavelength_nm" in roles:
        return table.numbers(roles["wavelength_nm"])
    return np.full(len(table), np.nan)
