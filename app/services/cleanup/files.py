"""A file cleaned without a window: marked, without its ghosts, corrected, or as proposed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.arrays import AnyArray
from app.core.errors import BadInput, WrongUse
from app.core.ghosts import SURE
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.formats.session import SUFFIX
from app.model.project import Project
from app.services.beams import propose_beam
from app.services.cleaning import mark_ghosts
from app.services.cleanup.answers import Answer, Uncertain
from app.services.cleanup.apply import make_step
from app.services.cleanup.areas import compare_areas
from app.services.cleanup.plan import Plan, plan_cleanup
from app.services.cleanup.report import add_up, describe
from app.services.cleanup.statistics import sum_up
from app.services.export import export, gather, merge, refuse_unwritable
from app.services.leaves import find_leaves, leaves_from_labels
from app.services.opening import Opening, open_file, set_parameters
from app.services.sessions import open_session

Mode = Literal["mark", "delete", "correct", "auto"]
MARKED_FIELDS = ("ghost_score", "ghost", "ghost_reason", "ghost_confidence")


@dataclass(frozen=True, slots=True)
class CleanRequest:
    """What is to be done with the ghosts of a file.

    Attributes
    ----------
    mode : {'mark', 'delete', 'correct', 'auto'}
        Write all points and fields that say which are ghosts and why; without the ghosts; with
        those put back that can be, the others marked; or as `uncertain` says.
    sure : float
        Confidence from which a ghost is corrected, 0 to 1.
    uncertain : {'delete', 'mark'} or None
        What becomes of the others in mode auto; see `plan_cleanup`.
    label_field : str or None
        Field whose whole numbers from 0 on name the leaves.
    find : bool
        Find leaves by connectivity.
    parameters : mapping
        Attributes of `Parameters` that differ from those of the file or session.
    """

    mode: Mode
    sure: float = SURE
    uncertain: Uncertain | None = None
    label_field: str | None = None
    find: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)


def clean_file(
    opening: Opening,
    out: Path,
    request: CleanRequest,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> dict[str, Any]:
    """Find ghosts in a scan file or a session and write what is left of it.

    Returns
    -------
    dict
        Counts over all scans of the file, and ``scans`` with all that is known of each.

    Raises
    ------
    BadInput
        Nothing can be corrected, and that was asked for.
    WrongUse, MissingScanner, Cancelled
    """
    refuse_unwritable(out)
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = _open(opening, progress.part(0.0, 0.3))
    scans = []
    for key in keys:
        _set(project, key, request.parameters)
        _make_leaves(project, key, request, progress.part(0.3, 0.4))
        scans.append(_clean(project, key, request, progress))
    fields = MARKED_FIELDS if request.mode == "mark" else ()
    moved = request.mode in ("correct", "auto")
    clouds = [gather(project, key, fields, traces=moved) for key in keys]
    export(merge(clouds), out, overwrite, progress.part(0.9, 1.0))
    return {"mode": request.mode, **add_up(scans)}


def _open(opening: Opening, progress: Progress) -> tuple[Project, list[str]]:
    if opening.path.suffix.lower() != SUFFIX:
        return open_file(opening, progress)
    if opening != Opening(opening.path):
        raise WrongUse(
            "A session knows how its files are read; options of reading belong to scan files.",
            "Leave --origin, --channel and the like out, or name the scan file.",
        )
    project, _ = open_session(opening.path, progress)
    keys = [key for key, state in project.state.scans.items() if not state.closed]
    if not keys:
        raise BadInput(f"There is no open scan in {opening.path.name}.")
    return project, keys


def _set(project: Project, scan: str, parameters: Mapping[str, Any]) -> None:
    """Take what was asked for; the beam, if nobody said, from the scan itself."""
    given = {name: value for name, value in parameters.items() if value is not None}
    state = project.state.scan(scan)
    if "beam" not in given and state.parameters.beam is None:
        given["beam"] = propose_beam(state.scan)
    set_parameters(project, scan, **given)


def _make_leaves(project: Project, scan: str, request: CleanRequest, progress: Progress) -> None:
    if request.label_field is not None:
        leaves_from_labels(project, scan, request.label_field)
    if request.find:
        find_leaves(project, scan, progress)


def _clean(
    project: Project, scan: str, request: CleanRequest, progress: Progress
) -> dict[str, Any]:
    mode = request.mode
    uncertain: Uncertain | None = request.uncertain if mode == "auto" else "mark"
    plan = plan_cleanup(project, scan, request.sure, uncertain, progress.part(0.4, 0.7))
    before = project.state.scan(scan)
    if mode == "correct" and plan.reasons is None:
        raise BadInput(
            f"{before.scan.name} has no rows and columns that could be used, so nothing can be "
            "corrected: what else a beam touched is told by the beams beside it.",
            "Use --mode mark or --mode delete, or open the scan in a format that keeps them.",
        )
    answers = _answer(plan, before.marks, mode)
    areas = compare_areas(project, plan, answers, progress.part(0.7, 0.9))
    if mode == "mark":
        mark_ghosts(project, scan)
    else:
        project.do(make_step(project.state, plan, answers))
    return describe(project, plan, sum_up(plan, answers, before.alive), areas)


def _answer(plan: Plan, marks: AnyArray, mode: Mode) -> AnyArray:
    """What becomes of each ghost; what the user keeps is kept in every mode."""
    if mode in ("auto", "correct"):
        return plan.answers(marks)
    same = Answer.LEAVE if mode == "mark" else Answer.DELETE
    return np.where(marks[plan.ghosts] < 0, Answer.KEEP, same).astype(np.int8)
