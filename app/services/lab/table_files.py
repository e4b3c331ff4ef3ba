"""Tables of fits as text: CSV long or wide as the paper prints them, LaTeX, and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from app.core.errors import BadInput, WrongUse
from app.core.units import to_degrees
from app.formats.atomic import atomic_path, refuse_target
from app.services.fit import FitReport, GroupFit, criteria_of
from app.services.lab.latex import as_latex
from app.services.lab.wide_table import Block, arrange_blocks
from app.services.labels import name_apart

Kind = Literal["csv", "tsv", "tex", "json"]
KINDS: dict[str, Kind] = {".csv": "csv", ".tsv": "tsv", ".tex": "tex", ".json": "json"}


def write_fits(report: FitReport, path: Path, wide: bool = False, overwrite: bool = False) -> None:
    """Write a table of fits, in the form that the ending of the file tells.

    Parameters
    ----------
    report : FitReport
    path : Path
        ``.csv`` or ``.tsv`` (a row per parameter of each fit, or wide), ``.tex`` (booktabs, always
        wide), ``.json``.
    wide : bool
        As Kaasalainen's Tables 3 and 4: a block per parameter, samples down, channels across.

    Raises
    ------
    WrongUse
        Another ending.
    BadInput
        The fits make no table of samples × channels, or the file cannot be written.
    """
    kind = kind_of(path)
    refuse_target(path, overwrite)
    text = fits_as_text(report, kind, wide)
    with atomic_path(path, overwrite) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def kind_of(path: Path) -> Kind:
    """The form that a file's ending asks for; raises `WrongUse` for another ending."""
    try:
        return KINDS[path.suffix.lower()]
    except KeyError:
        raise WrongUse(
            f"{path.name} is no table that can be written.", f"Endings: {', '.join(KINDS)}."
        ) from None


def fits_as_text(report: FitReport, kind: Kind, wide: bool = False) -> str:
    """A table of fits as text; see `write_fits`."""
    if not report.fits:
        raise BadInput("There is no fit to write.")
    if kind == "json":
        return json.dumps(report.as_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if kind == "tex":
        return as_latex(report)
    rows = _list_wide(arrange_blocks(report)) if wide else _list_long(report)
    text = io.StringIO()
    lines = csv.writer(text, delimiter="\t" if kind == "tsv" else ",", lineterminator="\r\n")
    lines.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def _list_long(report: FitReport) -> list[list[Any]]:
    """A row per parameter of each fit."""
    labels = list(report.fits[0].group)
    results = [
        "model", "fitted_to", "parameter", "value", "sd", "low_95", "high_95", "unit",
        "at_bound", "fixed", "n", "rss", "rmse", "r2", "aic", "aicc", "bic", "angle_min_deg",
        "angle_max_deg", "notes",
    ]  # fmt: skip
    head = [*name_apart(labels, results), *results]
    return [head, *(row for one in report.fits for row in _rows_of(one, labels))]


def _rows_of(one: GroupFit, labels: Sequence[str]) -> list[list[Any]]:
    r, notes = one.result, " ".join(one.warnings)
    start = [*(one.group[name] for name in labels), one.model.name]
    if r is None:
        return [
            [*start, None, p.name, *[None] * 4, p.unit, None, None, one.n, *[None] * 8, notes]
            for p in one.model.parameters
        ]
    kind = r.kind if r.tau is None else f"{r.kind} {r.tau:g}"
    low, high = (float(to_degrees(angle)) for angle in r.angle_range)
    end = [r.n, r.rss, r.rmse, r.r2, *criteria_of(r).values(), low, high, notes]
    rows = []
    for name, p in r.parameters.items():
        span = r.interval(name) or (None, None)
        rows.append(
            [*start, kind, name, p.value, p.sd, *span, p.unit, p.at_bound, p.fixed, *end]
        )  # fmt: skip
    return rows


def _list_wide(blocks: Sequence[Block]) -> list[list[Any]]:
    """Blocks one below the other: values, then standard deviations, of one parameter."""
    first = blocks[0]
    head = ["parameter", "quantity"]
    rows: list[list[Any]] = [[*head, *name_apart([first.down, *first.columns], head)]]
    for block in blocks:
        for quantity in ("value", "sd"):
            for name, cells in block.rows:
                numbers = [getattr(cell, quantity) if cell else None for cell in cells]
                rows.append([block.parameter, quantity, name, *numbers])
    return rows


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return repr(value)
    text = str(value)
    # A spreadsheet must not run a name as a formula.
    return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text
