"""``leafscope wrinkles``: from a file to a table of leaves, and a picture of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.formats.atomic import atomic_path, refuse_targets
from app.services.beams import beam_of_instrument, propose_beam
from app.services.leaves import Row, find_leaves, leaves_from_labels, write_table
from app.services.opening import Opening, open_file, set_parameters
from app.services.wrinkles.measure import ScanWrinkles, measure_wrinkles
from app.services.wrinkles.picture import draw_leaves, picture_kind
from app.services.wrinkles.request import TableCurve, WrinkleRequest
from app.services.wrinkles.table import tabulate

TABLES = (".csv", ".json")
NAME_BEAM = (
    "The beam of this scanner is unknown: name it (--instrument, or --exit-diameter and "
    "--half-divergence), and points that it hits in part are told apart."
)


@dataclass(frozen=True, slots=True)
class WrinkleReport:
    """What the command found: rows, warnings, and the files that it wrote."""

    rows: list[Row]
    warnings: tuple[str, ...]
    written: tuple[Path, ...]

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "leaves": self.rows,
            "warnings": list(self.warnings),
            "written": [str(path) for path in self.written],
        }


def tabulate_wrinkles(
    opening: Opening,
    out: Path,
    request: WrinkleRequest,
    label_field: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    picture: Path | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> WrinkleReport:
    """Measure the wrinkles of all leaves of a file, write a row per leaf, and draw them.

    Parameters
    ----------
    out : Path
        .csv or .json.
    label_field : str or None
        Field whose whole numbers from 0 on name the leaves; None finds them.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    picture : Path or None
        .png, .svg or .pdf.

    Raises
    ------
    LeafscopeError
        A file cannot be read or written, no leaf is found, or the request cannot be met.
    """
    refuse(opening, out, request, picture, overwrite)
    project, keys = open_file(opening, progress.part(0.0, 0.3))
    rows: list[Row] = []
    warnings: list[str] = []
    drawn: list[ScanWrinkles] = []
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        state = project.state.scan(key)
        if state.parameters.beam is None:
            named = request.instrument
            beam = propose_beam(state.scan) if named is None else beam_of_instrument(named)
            set_parameters(project, key, beam=beam)
        if label_field is None:
            find_leaves(project, key, progress.part(0.3, 0.5))
        else:
            leaves_from_labels(project, key, label_field)
        found = measure_wrinkles(project, key, request, None, progress.part(0.5, 0.95))
        if project.state.scan(key).parameters.beam is None:
            warnings.append(NAME_BEAM)
        drawn.append(found)
        rows += [{"scan": state.scan.name, **row} for row in tabulate(found)]
        warnings += found.warnings
    if not rows:
        raise BadInput(f"No leaf was found in {opening.path.name}.")
    write_rows(rows, out, overwrite)
    if picture is not None:
        leaves = [leaf for found in drawn for leaf in found.leaves]
        draw_leaves(leaves, picture, overwrite)
    written = (out,) if picture is None else (out, picture)
    return WrinkleReport(rows, tuple(dict.fromkeys(warnings)), written)


def refuse(
    opening: Opening, out: Path, request: WrinkleRequest, picture: Path | None, overwrite: bool
) -> None:
    """Raise before the work where its files could not be written."""
    if out.suffix.lower() not in TABLES:
        raise WrongUse(f"A table ends with {' or '.join(TABLES)}, not {out.suffix!r}.")
    if picture is not None:
        picture_kind(picture)
    sources = [opening.path]
    if isinstance(request.source, TableCurve):
        sources.append(request.source.path)
    refuse_targets(filter(None, (out, picture)), overwrite, sources)


def write_rows(rows: list[Row], out: Path, overwrite: bool = False) -> None:
    """Write a table of leaves, by the ending of its file."""
    if out.suffix.lower() == ".csv":
        write_table(rows, out, overwrite)
        return
    with atomic_path(out, overwrite) as temporary:
        temporary.write_text(json.dumps({"leaves": rows}, indent=1, ensure_ascii=False), "utf-8")
