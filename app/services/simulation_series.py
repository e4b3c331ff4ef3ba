"""A series of simulated scans: one value of the scene varied, a file per step, and a table."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.services.export import refuse_unwritable
from app.services.leaves import Row, write_table
from app.services.simulation import (
    Targets,
    describe_origin,
    refuse_combination,
    scan,
    write,
)
from app.services.simulation_order import Order, change, set_up
from app.services.truth_tables import name_columns, tabulate_truth
from app.simulate.scene_file import Document, decode_scene
from app.simulate.series import Series, parse_series, series_of
from app.simulate.simulation import Simulation
from app.simulate.virtual_scan import find_instrument


@dataclass(frozen=True, slots=True)
class Step:
    """One scan of a series."""

    value: Any
    document: Document
    file: Path


def simulate_series(
    order: Order, series: str, targets: Targets, progress: Progress = QUIET
) -> dict[str, Any]:
    """Scan a scene once for every value of a series.

    Steps that are done stay when a later one fails or is cancelled, and the table names them:
    it is written anew after every step.

    Parameters
    ----------
    series : str
        Such as ``stage.angle_deg=0:85:5``; empty: the one that the scene is for.
    targets : Targets
        `points` is a folder for ``SCENE_KEY_VALUE.laz`` and ``series.csv``, or a file such as
        ``run.e57`` for ``run_KEY_VALUE.e57`` and ``run_series.csv``. `leaves` holds the leaves
        of all steps.

    Returns
    -------
    dict
        scene, instruments, key, steps (a report as of `simulate_file` each), beams, points,
        ghosts, seconds, million_beams_per_second, warnings, table; leaves_file where it was
        asked for.

    Raises
    ------
    WrongUse, BadInput
        As `simulate_file`; all steps and all files are looked at before the first scan.
    Cancelled
    """
    document = order.document()
    wanted = choose_series(document, series, order.origin)
    table, steps = plan(order, document, wanted, targets.points)
    refuse(table, steps, targets)
    rows: list[Row] = []
    leaves: list[Row] = []
    reports: list[dict[str, Any]] = []
    for number, step in enumerate(steps):
        part = progress.part(number / len(steps), (number + 1) / len(steps))
        simulation, report = run_step(order, step, targets, part)
        place: Row = {"file": step.file.name, "key": wanted.path, "value": show_value(step.value)}
        rows.append(place | {"points": report["points"]})
        reports.append({"value": step.value} | report)
        write_table(rows, table, overwrite=True)
        if targets.leaves is not None:
            leaves += [place | row for row in tabulate_truth(simulation)]
            columns = (*place, *name_columns(simulation.scene.wavelengths_nm))
            write_table(leaves, targets.leaves, overwrite=True, columns=columns)
    found = sum_up(reports) | {"key": wanted.path, "steps": reports, "table": str(table)}
    return found | ({"leaves_file": str(targets.leaves)} if targets.leaves is not None else {})


def run_step(
    order: Order, step: Step, targets: Targets, progress: Progress
) -> tuple[Simulation, dict[str, Any]]:
    """Scan one step and write its points; its report."""
    setup = set_up(step.document, order.origin, order.noise)
    step.file.parent.mkdir(parents=True, exist_ok=True)
    mine = replace(targets, points=step.file, leaves=None)
    simulation, report = scan(setup, mine, progress.part(0.0, 0.8))
    made_of = describe_origin(order, step.document)
    return simulation, report | write(simulation, mine, made_of, progress.part(0.8, 1.0))


def choose_series(document: Document, text: str, origin: str) -> Series:
    """The series that is asked for, else the scene's own."""
    if text:
        return parse_series(text)
    table = decode_scene(document, origin).series
    if table is None:
        raise WrongUse(f"The scene {origin} has no series of its own.", "Say PATH=VALUES.")
    return series_of(table)


def plan(order: Order, document: Document, series: Series, out: Path) -> tuple[Path, list[Step]]:
    """The table and the steps of a series, each with its scene and its file."""
    if out.is_dir() or not out.suffix:
        name = decode_scene(document, order.origin).name
        folder, stem, suffix, table = out, clean(name), ".laz", "series.csv"
    else:
        refuse_unwritable(out)
        folder, stem, suffix, table = out.parent, out.stem, out.suffix, f"{out.stem}_series.csv"
    key = clean(series.path.rpartition(".")[2])
    steps = [
        Step(
            value,
            change(document, ((series.path, value),), order.origin),
            folder / f"{stem}_{key}_{clean(show_value(value))}{suffix}",
        )
        for value in series.values
    ]
    return folder / table, steps


def refuse(table: Path, steps: list[Step], targets: Targets) -> None:
    """Raise early where a file of the series must not or cannot be written."""
    if targets.waveforms is not None:
        raise WrongUse("Waveforms are written for one scan, not for a series.", "Use --set.")
    twice = [file for file, count in Counter(step.file for step in steps).items() if count > 1]
    if twice:
        raise WrongUse(f"Two steps of the series would be written to {twice[0].name}.")
    if table.parent.exists() and not table.parent.is_dir():
        raise BadInput(f"{table.parent} is no folder.", "Give the name of a folder.")
    for step in steps:
        tool = find_instrument(decode_scene(step.document, step.file.name).instrument)
        refuse_combination(tool, replace(targets, points=step.file))
    for path in (table, *(step.file for step in steps)):
        refuse_target(path, targets.overwrite, folder_follows=True)
    if targets.leaves is not None:
        refuse_target(targets.leaves, targets.overwrite)


def sum_up(reports: list[dict[str, Any]]) -> dict[str, Any]:
    """What the steps came to together."""
    beams, points, seconds = (
        sum(r[key] for r in reports) for key in ("beams", "points", "seconds")
    )
    ghosts = sum(report["ghosts"] * report["points"] for report in reports)
    return {
        "scene": reports[0]["scene"],
        "instruments": list(dict.fromkeys(report["instrument"] for report in reports)),
        "beams": beams,
        "points": points,
        "ghosts": ghosts / max(points, 1),
        "seconds": seconds,
        "million_beams_per_second": beams / seconds / 1e6,
        "warnings": [
            f"{Path(report['file']).name}: {text}"
            for report in reports
            for text in report["warnings"]
        ],
    }


def show_value(value: Any) -> str:
    """A value of a series as people write it: 30, 0.5, salca."""
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def clean(text: str) -> str:
    """Text as a part of a file's name."""
    return re.sub(r"[^\w.+-]+", "_", text).strip("_") or "_"
