"""Panels of known reflectance as one channel of an instrument saw them: the data of a calibration.

Nothing here fits; `check_panels` says in one sentence why a table cannot be used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import BadInput

BRIGHTEST = 1.5
"""Reflectance factor above which a column can only hold percent; glossy panels may exceed 1."""
SAME_RANGE = 0.02
"""Metres within which a panel stands still."""


@dataclass(frozen=True, slots=True, eq=False)
class PanelTable:
    """A row for each panel of each scan, in one channel.

    Attributes
    ----------
    distance : (n,) array
        Metres.
    dn : (n,) array
        What the instrument wrote down: the mean of a panel's returns.
    reflectance : (n,) array
        A fraction, not percent.
    scan, panel : (n,) arrays of str
    wavelength_nm : float
    channel : str
    dn_sigma : (n,) array or None
        σ of `dn`; None: unknown, then the fit estimates it.
    reflectance_sigma : (n,) array
        σ of the panel's reflectance, shared by all rows of the panel.
    lines : (n,) array
        Where each row stands in its file, for messages.
    """

    distance: Floats
    dn: Floats
    reflectance: Floats
    scan: AnyArray
    panel: AnyArray
    wavelength_nm: float
    channel: str
    dn_sigma: Floats | None
    reflectance_sigma: Floats
    lines: Ints

    def __len__(self) -> int:
        return len(self.dn)

    @property
    def scans(self) -> tuple[str, ...]:
        """Names of the scans, in the order of the table."""
        return tuple(dict.fromkeys(self.scan.tolist()))

    @property
    def panels(self) -> tuple[str, ...]:
        """Names of the panels, in the order of the table."""
        return tuple(dict.fromkeys(self.panel.tolist()))

    def index_scans(self) -> Ints:
        """Place of each row's scan in `scans`, (n,)."""
        return _index(self.scan, self.scans)

    def index_panels(self) -> Ints:
        """Place of each row's panel in `panels`, (n,)."""
        return _index(self.panel, self.panels)

    def pick(self, rows: Bools) -> PanelTable:
        """The same table with some of its rows."""
        chosen: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            chosen[each.name] = value[rows] if isinstance(value, np.ndarray) else value
        return PanelTable(**chosen)


def make_table(
    distance: Floats,
    dn: Floats,
    reflectance: Floats,
    wavelength_nm: float,
    *,
    scan: Sequence[str] | AnyArray | None = None,
    panel: Sequence[str] | AnyArray | None = None,
    channel: str = "",
    dn_sigma: Floats | None = None,
    reflectance_sigma: Floats | float = 0.0,
    lines: Sequence[int] | None = None,
) -> PanelTable:
    """Make a table of columns; scans default to one, panels are named by their reflectance."""
    rho = np.asarray(reflectance, float)
    count = len(rho)
    names = [f"{value:g}" for value in rho] if panel is None else panel
    return PanelTable(
        np.asarray(distance, float),
        np.asarray(dn, float),
        rho,
        np.array(["1"] * count if scan is None else scan, dtype=str),
        np.array(names, dtype=str),
        float(wavelength_nm),
        channel or f"intensity_{wavelength_nm:g}",
        None if dn_sigma is None else np.asarray(dn_sigma, float),
        np.broadcast_to(np.asarray(reflectance_sigma, float), rho.shape).copy(),
        np.arange(1, count + 1) if lines is None else np.asarray(lines, np.int64),
    )


def to_fractions(table: PanelTable) -> PanelTable:
    """A table whose reflectances are given in percent, in fractions.

    Raises
    ------
    BadInput
        They are fractions already.
    """
    if len(table) and table.reflectance.max() <= 1.0:
        raise BadInput(
            f"The largest reflectance is {table.reflectance.max():g}, no percent but a fraction.",
            "Leave --percent out.",
        )
    return replace(
        table,
        reflectance=table.reflectance / 100,
        reflectance_sigma=table.reflectance_sigma / 100,
    )


def check_panels(table: PanelTable) -> None:
    """Refuse a table that no model can be fitted to.

    Raises
    ------
    BadInput
        A number is missing or impossible, reflectances are percent, or a panel is there twice.
    """
    if not len(table):
        raise BadInput("The table has no rows for this channel.")
    _check_numbers(table)
    _check_percent(table)
    _check_twice(table)


def find_fixed_panels(table: PanelTable) -> tuple[str, ...]:
    """Panels that every scan saw, always at the same range: what drift is measured by."""
    if len(table.scans) < 2:
        return ()
    return tuple(
        panel for panel in table.panels if _stands_still(table.pick(table.panel == panel), table)
    )


def _stands_still(rows: PanelTable, table: PanelTable) -> bool:
    still = float(np.ptp(rows.distance)) <= SAME_RANGE
    return still and len(rows.scans) == len(table.scans)


def _check_numbers(table: PanelTable) -> None:
    columns = {"range": table.distance, "DN": table.dn, "reflectance": table.reflectance}
    if table.dn_sigma is not None:
        columns["σ of the DN"] = table.dn_sigma
    for name, values in columns.items():
        _refuse_row(table, ~np.isfinite(values), f"has no {name}", "Fill it in or remove the row.")
    _refuse_row(table, table.distance <= 0, "has a range that is not above 0", "Give metres.")
    _refuse_row(
        table, table.reflectance <= 0, "has a reflectance that is not above 0", "Correct it."
    )
    if table.dn_sigma is not None:
        _refuse_row(table, table.dn_sigma <= 0, "has a σ of the DN not above 0", "Correct it.")
    unsure = ~(table.reflectance_sigma >= 0)
    _refuse_row(table, unsure, "has no σ of the reflectance, or a negative one", "Correct it.")


def _refuse_row(table: PanelTable, bad: Bools, fault: str, hint: str) -> None:
    if bad.any():
        line = int(table.lines[np.argmax(bad)])
        more = f" ({int(bad.sum())} such rows)" if bad.sum() > 1 else ""
        raise BadInput(f"Row {line}, panel {table.panel[np.argmax(bad)]}, {fault}{more}.", hint)


def _check_percent(table: PanelTable) -> None:
    brightest = float(table.reflectance.max())
    if brightest > BRIGHTEST:
        raise BadInput(
            f"A reflectance of {brightest:g} looks like percent, not a fraction.",
            "Say --percent if it is; otherwise correct it.",
        )


def _check_twice(table: PanelTable) -> None:
    seen: dict[tuple[str, str, float], int] = {}
    told: dict[str, float] = {}
    rows = zip(table.scan, table.panel, table.distance, table.reflectance, table.lines, strict=True)
    for scan, panel, distance, rho, line in rows:
        key = (str(scan), str(panel), float(distance))
        if key in seen:
            raise BadInput(
                f"Panel {panel} is there twice in scan {scan} at {distance:g} m: "
                f"rows {seen[key]} and {line}.",
                "Keep one of them, or their mean.",
            )
        seen[key] = int(line)
        if told.setdefault(key[1], float(rho)) != float(rho):
            raise BadInput(
                f"Panel {panel} has two reflectances, {told[key[1]]:g} and {rho:g} (row {line}).",
                "Give the panels different names, or correct one.",
            )


def _index(names: AnyArray, known: Sequence[str]) -> Ints:
    place = {name: k for k, name in enumerate(known)}
    return np.array([place[name] for name in names.tolist()], np.int64)
