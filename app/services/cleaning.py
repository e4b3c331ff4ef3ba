"""Ghost points: found by score, then marked, deleted or corrected; each is one step."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.progress import QUIET, Progress
from app.core.units import group_digits
from app.formats.atomic import refuse_target
from app.model.neighbours import neighbours_of
from app.model.operations import (
    Coordinates,
    MarkGhosts,
    MovePoints,
    SetDeleted,
    Several,
)
from app.model.points import PointSet
from app.model.project import Project
from app.model.selection import FieldRange
from app.services.export import export, gather, merge, refuse_unwritable
from app.services.opening import Opening, open_file, set_parameters

Mode = Literal["mark", "delete", "correct"]


def find_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> PointSet:
    """Points that count as ghosts now: by the user's marks, else by score and threshold."""
    ghost = project.field(scan, "ghost", None, progress)
    return PointSet.from_mask((ghost == 1.0) & project.state.scan(scan).alive)


def mark_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> int:
    """Mark the ghosts; give their number."""
    ghosts = find_ghosts(project, scan, progress)
    threshold = project.state.scan(scan).parameters.ghost_threshold
    project.do(MarkGhosts(scan, ghosts=ghosts, basis=FieldRange("ghost_score", threshold, 1.0)))
    return len(ghosts)


def delete_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> int:
    """Delete the ghosts (a mask: undo brings them back); give their number."""
    ghosts = find_ghosts(project, scan, progress)
    project.do(SetDeleted(scan, ghosts, True, FieldRange("ghost", 1.0, 1.0)))
    return len(ghosts)


def correct_ghosts(project: Project, scan: str, progress: Progress = QUIET) -> tuple[int, int]:
    """Put ghosts back on the surface that dominates their beam, where there is one.

    Returns
    -------
    corrected, left : int
        Ghosts that were moved, and ghosts without a surface nearby, which stay marked.
    """
    from app.core.ghosts import correct_ghosts as correct

    ghosts = find_ghosts(project, scan, progress)
    state = project.state.scan(scan)
    scanner = state.scan.scanner("the correction of ghosts")
    grid = neighbours_of(state.scan, progress).grid
    moved, done = correct(state.scan.xyz, scanner, ghosts.indices, grid)
    corrected = PointSet(ghosts.indices[done])
    steps = (
        MovePoints(scan, corrected, Coordinates(moved[done])),
        MarkGhosts(scan, ghosts=ghosts - corrected, kept=corrected),
    )
    project.do(
        Several(
            f"Correct {group_digits(len(corrected))} of {group_digits(len(ghosts))} ghosts", steps
        )
    )
    return len(corrected), len(ghosts) - len(corrected)


def clean_file(
    opening: Opening,
    mode: Mode,
    out: Path,
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> dict[str, Any]:
    """Find ghosts in a file and write it marked, without them, or with them corrected.

    Parameters
    ----------
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.

    Returns
    -------
    dict
        Counts of points, ghosts, and of what was done with them.
    """
    refuse_unwritable(out)
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    report: dict[str, Any] = {"points": 0, "ghosts": 0, "mode": mode}
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        _clean_scan(project, key, mode, report, progress.part(0.4, 0.9))
    fields = ("ghost_score", "ghost") if mode == "mark" else ()
    clouds = [gather(project, key, fields) for key in keys]
    export(merge(clouds), out, overwrite, progress.part(0.9, 1.0))
    return report


def _clean_scan(
    project: Project, scan: str, mode: Mode, report: dict[str, Any], progress: Progress
) -> None:
    report["points"] += int(np.count_nonzero(project.state.scan(scan).alive))
    if mode == "mark":
        report["ghosts"] += mark_ghosts(project, scan, progress)
    elif mode == "delete":
        report["ghosts"] += delete_ghosts(project, scan, progress)
    else:
        corrected, left = correct_ghosts(project, scan, progress)
        report["ghosts"] += corrected + left
        report["corrected"] = report.get("corrected", 0) + corrected
        report["left"] = report.get("left", 0) + left
