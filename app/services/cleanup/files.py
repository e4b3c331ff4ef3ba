"""A file cleaned without a window: marked, without its ghosts, corrected, or as proposed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.ghosts import BEAM, SURE
from app.core.ghosts import WORDS as REASONS
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.model.ghost_fields import ASSUMED
from app.model.parameters import Beam
from app.model.project import Project
from app.services.beams import describe_beam, propose_beam
from app.services.cleaning import mark_ghosts
from app.services.cleanup.answers import Answer, Uncertain
from app.services.cleanup.apply import make_step
from app.services.cleanup.plan import Plan, plan_cleanup
from app.services.cleanup.statistics import Statistics, sum_up
from app.services.export import export, gather, merge, refuse_unwritable
from app.services.opening import Opening, open_file, set_parameters

Mode = Literal["mark", "delete", "correct", "auto"]
MARKED_FIELDS = ("ghost_score", "ghost", "ghost_reason", "ghost_confidence")
SUMMED = ("points", "ghosts", "corrected", "deleted", "kept", "left_marked", "open")


def clean_file(
    opening: Opening,
    mode: Mode,
    out: Path,
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
    sure: float = SURE,
    uncertain: Uncertain = "delete",
) -> dict[str, Any]:
    """Find ghosts in a file and write what is left of it.

    Parameters
    ----------
    mode : {'mark', 'delete', 'correct', 'auto'}
        Write all points and fields that say which are ghosts and why; without the ghosts; with
        those put back that can be, the others marked; or as `uncertain` says.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.
    sure : float
        Confidence from which a ghost is corrected, 0 to 1.
    uncertain : {'delete', 'mark'}
        What becomes of the others in mode auto.

    Returns
    -------
    dict
        Counts over all scans of the file, and ``scans`` with all that is known of each.
    """
    refuse_unwritable(out)
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    scans = []
    for key in keys:
        _set(project, key, parameters or {})
        what: Uncertain = uncertain if mode == "auto" else "mark"
        plan = plan_cleanup(project, key, sure, what, progress.part(0.4, 0.9))
        scans.append(_describe(project, plan, _carry_out(project, plan, mode)))
    fields = MARKED_FIELDS if mode == "mark" else ()
    clouds = [gather(project, key, fields) for key in keys]
    export(merge(clouds), out, overwrite, progress.part(0.9, 1.0))
    return _total(mode, scans)


def _set(project: Project, scan: str, parameters: Mapping[str, Any]) -> None:
    """Take what was asked for; the beam, if nobody said, from the scan itself."""
    given = {name: value for name, value in parameters.items() if value is not None}
    if "beam" not in given:
        given["beam"] = propose_beam(project.state.scan(scan).scan)
    set_parameters(project, scan, **given)


def _carry_out(project: Project, plan: Plan, mode: Mode) -> Statistics:
    state = project.state.scan(plan.scan)
    if mode == "mark":
        mark_ghosts(project, plan.scan)
        answers = np.full(len(plan), Answer.LEAVE, np.int8)
    else:
        answers = plan.answers(state.marks)
        if mode == "delete":
            answers[:] = Answer.DELETE
        project.do(make_step(project.state, plan, answers))
    return sum_up(plan, answers, state.alive)


def _describe(project: Project, plan: Plan, found: Statistics) -> dict[str, Any]:
    state = project.state.scan(plan.scan)
    beam = state.parameters.beam
    told = found.as_json()
    for reason in told["reasons"].values():
        reason.pop("open")
    return {
        "scan": state.scan.name,
        "method": plan.method,
        "beam": _say_beam(beam),
        "threshold": plan.threshold,
        "sure": plan.sure,
        **told,
    }


def _say_beam(beam: Beam | None) -> str:
    if beam is not None:
        return describe_beam(beam)
    return describe_beam(Beam(BEAM.radius, BEAM.half_divergence, ASSUMED))


def _total(mode: Mode, scans: list[dict[str, Any]]) -> dict[str, Any]:
    methods = list(dict.fromkeys(scan["method"] for scan in scans))
    beams = list(dict.fromkeys(scan["beam"] for scan in scans))
    moved = [scan["shift_median_mm"] for scan in scans if scan["shift_median_mm"] is not None]
    return {
        "mode": mode,
        "score_from": "; ".join(methods),
        "beam": "; ".join(beams),
        "threshold": scans[0]["threshold"],
        "sure": scans[0]["sure"],
        **{name: sum(scan[name] for scan in scans) for name in SUMMED if name != "open"},
        "shift_median_mm": moved[0] if len(scans) == 1 and moved else None,
        "reason_numbers": {str(int(number)): word for number, word in REASONS.items()},
        "scans": scans,
    }
