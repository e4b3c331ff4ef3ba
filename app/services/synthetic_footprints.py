"""How the spread of an index falls with the size of a synthetic footprint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from app.core.arrays import Floats, Ints
from app.core.channel_index import ChannelIndex, choose_index
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.core.synthetic_footprint import check_diameter, find_lines, smooth
from app.core.units import MM_PER_M
from app.formats.atomic import refuse_target
from app.model.neighbours import neighbours_of
from app.model.operations import SetParameters
from app.model.project import Project
from app.services.curves import members_of
from app.services.leaves import Row, leaves_from_labels, write_table
from app.services.opening import Opening, open_file

DIAMETERS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
MOST_ASKED = 100_000
"""Footprints that a spread is taken over, evenly through the scan; every point is averaged."""
ERROR = 0.02


@dataclass(frozen=True, slots=True)
class Spread:
    """Spread of an index against the diameter of the footprint.

    Attributes
    ----------
    index : ChannelIndex
    rows : list of Row
        diameter_mm (0: single points), n, mean, sd, low and high (2.5 and 97.5 %), points (the
        median number in a footprint).
    error : float
    reached_mm : float or None
        Diameter from which on the sd stays below `error`, between the sizes by a straight line
        of both logarithms; None where it never does.
    """

    index: ChannelIndex
    rows: list[Row]
    error: float
    reached_mm: float | None

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope synthetic-footprint``."""
        return {
            "index": self.index.name,
            "channels": list(self.index.channels),
            "picks": [pick.words for pick in self.index.picks],
            "rows": self.rows,
            "error": self.error,
            "reached_mm": self.reached_mm,
        }


def set_synthetic_footprint(
    project: Project, scan: str, diameter: float | None, drag: str = ""
) -> None:
    """Smooth the channels of a scan at a size in metres, or (None) no more.

    Fields ``…_smoothed`` of channels and indices are there while a size is set. The steps of one
    slider drag merge into one step of the history.

    Raises
    ------
    WrongUse
        The diameter is none.
    """
    old = project.state.scan(scan).parameters
    project.do(SetParameters(scan, replace(old, synthetic_footprint=diameter), drag))


def index_in(project: Project, scan: str, text: str) -> ChannelIndex:
    """An index over channels of one workflow: ``ndi``, ``ndi_wf2``, or a formula.

    Raises
    ------
    MissingChannel, WrongUse
        See `app.core.channel_index.choose_index`.
    """
    state = project.state.scan(scan)
    formulas = {formula.name: formula.text for formula in state.parameters.formulas}
    for workflow in state.workflows[1:]:
        if text.endswith(f"_{workflow}") and text.isidentifier() and text not in formulas:
            own, stem = state.wavelengths_of(workflow), text.removesuffix(f"_{workflow}")
            return choose_index(formulas.get(stem, stem), own)
    names = [channel.name for channel in state.channels]
    return choose_index(formulas.get(text, text), state.wavelengths, names)


def spread_of_index(
    project: Project,
    scan: str,
    index: str,
    diameters: Sequence[float] = DIAMETERS,
    *,
    leaves: Sequence[str] = (),
    error: float = ERROR,
    progress: Progress = QUIET,
) -> Spread:
    """Spread of an index over synthetic footprints of several diameters.

    Parameters
    ----------
    project, scan
    index : str
        A name or a formula.
    diameters : sequence of float
        Metres.
    leaves : sequence of str
        Average over the points of these leaves only, and ask about these; none named: all.
    error : float
        Spread (sd) that is to be reached.

    Raises
    ------
    BadInput
        No point has the index.
    WrongUse
        A diameter that is none, or an error that is not positive.
    """
    for diameter in diameters:
        check_diameter(diameter)
    if not error > 0.0:
        raise WrongUse(f"The error to be reached must be positive, not {error:g}.")
    chosen, state = index_in(project, scan, index), project.state.scan(scan)
    scanner = state.scan.scanner("a synthetic footprint")
    grid = neighbours_of(state.scan, progress).grid
    lines = find_lines(state.scan.xyz, scanner, grid)
    left_out = ~state.alive
    members = members_of(project, scan, leaves)
    if members is not None:
        left_out = np.ones(len(left_out), bool)
        left_out[members] = ~state.alive[members]
    values = np.array([project.field(scan, name, None, progress) for name in chosen.channels])
    points = _choose(np.flatnonzero(~left_out & np.isfinite(values).all(axis=0)))
    rows = [_sum_up(0.0, _index_at(chosen, values[:, points]), np.ones(len(points), np.int64))]
    for number, diameter in enumerate(sorted(diameters)):
        part = progress.part(number / len(diameters), (number + 1) / len(diameters))
        found = smooth(
            values, state.scan.xyz, scanner, grid, diameter, points, left_out, part, lines
        )
        rows.append(_sum_up(diameter, _index_at(chosen, found.values), found.count))
    if not rows[0]["n"]:
        raise BadInput(f"No point of {state.scan.name} has a value of {index}.")
    return Spread(chosen, rows, error, find_reached(rows, error))


def _choose(points: Ints) -> Ints:
    if len(points) <= MOST_ASKED:
        return points
    return points[np.linspace(0, len(points) - 1, MOST_ASKED).astype(np.int64)]


def _index_at(index: ChannelIndex, values: Floats) -> Floats:
    return index.evaluate(dict(zip(index.channels, values, strict=True)))


def _sum_up(diameter: float, values: Floats, count: Ints) -> Row:
    known = values[np.isfinite(values)]
    some = len(known) > 1
    low, high = np.quantile(known, (0.025, 0.975)) if some else (np.nan, np.nan)
    return {
        "diameter_mm": diameter * MM_PER_M,
        "n": len(known),
        "mean": float(known.mean()) if some else None,
        "sd": float(known.std(ddof=1)) if some else None,
        "low": float(low) if some else None,
        "high": float(high) if some else None,
        "points": float(np.median(count)) if len(count) else None,
    }


def find_reached(rows: Sequence[Row], error: float) -> float | None:
    """Diameter, mm, from which on the sd stays at or below an error; None where it never does."""
    size = np.array([float(row["diameter_mm"] or 0.0) for row in rows])
    sd = np.array([np.nan if row["sd"] is None else float(row["sd"]) for row in rows])
    above = np.flatnonzero(~(sd <= error))
    if not len(above):
        return float(size[0])
    last = int(above[-1])
    if last == len(rows) - 1:
        return None
    if size[last] == 0.0 or sd[last + 1] <= 0.0 or not np.isfinite(sd[last]):
        return float(size[last + 1])  # no logarithm: the next size is sure to do
    share = np.log(sd[last] / error) / np.log(sd[last] / sd[last + 1])
    return float(size[last] * (size[last + 1] / size[last]) ** share)


def tabulate_spread(
    opening: Opening,
    out: Path,
    index: str,
    diameters: Sequence[float] = DIAMETERS,
    *,
    label_field: str | None = None,
    error: float = ERROR,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> Spread:
    """Read a file and write the spread of an index against the diameter as CSV.

    With a label field only points of labelled leaves count; see `spread_of_index` for the rest.
    """
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    if len(keys) > 1:
        raise WrongUse(f"{opening.path.name} holds {len(keys)} scans; a footprint is of one.")
    leaves = leaves_from_labels(project, keys[0], label_field) if label_field else []
    found = spread_of_index(
        project, keys[0], index, diameters, leaves=leaves, error=error,
        progress=progress.part(0.4, 1.0),
    )  # fmt: skip
    write_table(found.rows, out, overwrite)
    return found
