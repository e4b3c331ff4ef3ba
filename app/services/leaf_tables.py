"""The table of leaves of a file: labels or connectivity, measured and written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.core.errors import BadInput
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.services.leaf_seeds import make_leaves, read_seeds
from app.services.leaves import Row, measure_leaves, write_table
from app.services.opening import Opening, open_file, set_parameters
from app.services.surfaces.meshes import measure_areas


def tabulate_leaves(
    opening: Opening,
    out: Path,
    label_field: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
    seeds: Path | None = None,
) -> list[Row]:
    """Measure all leaves of a file and write them as CSV, a row per leaf.

    Parameters
    ----------
    label_field : str or None
        Field whose whole numbers from 0 on name the leaves; None finds them by
        connectivity.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    seeds : Path or None
        Table of places that split, merge and name leaves, see `app.services.leaf_seeds`.

    Raises
    ------
    BadInput
        No leaf was found, or a seed lies on none.
    """
    refuse_target(out, overwrite, sources=list(filter(None, [opening.path, seeds])))
    given = None if seeds is None else read_seeds(seeds)
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    rows: list[Row] = []
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        make_leaves(project, key, label_field, given, progress.part(0.4, 0.7))
        measured = measure_leaves(project, key, None, progress.part(0.7, 0.85))
        leaves = project.state.leaves_of(key)
        areas = measure_areas(project, key, leaves, progress.part(0.85, 1.0))
        name = project.state.scan(key).scan.name
        rows += [{"scan": name, **row, **areas[str(row["leaf"])]} for row in measured]
    if not rows:
        raise BadInput(f"No leaf was found in {opening.path.name}.")
    write_table(rows, out, overwrite)
    return rows
