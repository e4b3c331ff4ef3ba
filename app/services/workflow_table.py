"""Workflows side by side: each leaf and channel under WF1, WF2 and WF3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.core.workflows.chain import LEAST_BRACKET, get_workflow
from app.core.workflows.marks import GOOD
from app.formats.atomic import refuse_target
from app.model.correction_fields import MARK
from app.model.corrections import Correction, describe_correction
from app.model.leaf import Leaf
from app.model.project import Project
from app.services.correction_doubts import doubt_correction
from app.services.corrections import (
    apply_corrections,
    correction_of_fit,
    warn_about_source,
)
from app.services.curves import fit_leaves
from app.services.leaves import Row, find_leaves, leaves_from_labels, write_table
from app.services.opening import Opening, open_file, set_parameters

CALIBRATED = "wf1"
FitTo = Literal["leaf", "all"]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is corrected, and with which numbers.

    Attributes
    ----------
    channels : tuple of str
        Empty: all that are not corrected.
    workflows : tuple of str
    fit_to : {'leaf', 'all'} or None
        Fit each leaf on its own, or all leaves together; None fits nothing, for corrections that
        the opening names.
    least_bracket : float
    leaves : tuple of str or None
        Keys of the leaves that are fitted and corrected; None: all of them, and one fit for all
        corrects all points. Empty: the whole scan.
    """

    channels: tuple[str, ...] = ()
    workflows: tuple[str, ...] = ("wf2", "wf3")
    fit_to: FitTo | None = "all"
    least_bracket: float = LEAST_BRACKET
    leaves: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class WorkflowTable:
    """Rows of leaves and channels, the corrections in use, and what could not be done."""

    rows: list[Row]
    corrections: tuple[Correction, ...]
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The JSON answer of ``leafscope correct``."""
        used = [
            {"channel": c.name, "leaves": list(c.leaves), "values": c.values, "origin": c.origin}
            for c in self.corrections
        ]
        return {"rows": self.rows, "corrections": used, "warnings": list(self.warnings)}


def tabulate_workflows(
    opening: Opening,
    out: Path,
    wanted: Wanted,
    *,
    label_field: str | None = None,
    parameters: dict[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> WorkflowTable:
    """Correct the channels of a file and write leaves × channels under each workflow as CSV.

    Raises
    ------
    BadInput
        No leaf was found, or none could be corrected.
    WrongUse, MissingChannel, MissingScanner
        See `app.services.corrections.apply_corrections`.
    """
    if wanted.fit_to is None and not opening.corrections:
        raise WrongUse("Nothing is fitted and no correction is named.", "Name one by --correct.")
    refuse_target(out, overwrite, sources=[opening.path])
    project, keys = open_file(opening, progress.part(0.0, 0.3))
    rows: list[Row] = []
    warnings: list[str] = []
    used: list[Correction] = []
    for key in keys:
        set_parameters(project, key, **(parameters or {}))
        if label_field is not None:
            leaves_from_labels(project, key, label_field)
        else:
            find_leaves(project, key, progress.part(0.3, 0.5))
        warnings += correct_leaves(project, key, wanted, progress.part(0.5, 0.9))
        name = project.state.scan(key).scan.name
        rows += [{"scan": name, **row} for row in compare_workflows(project, key)]
        used += project.state.scan(key).parameters.corrections
    if not rows:
        raise BadInput(f"No leaf was found in {opening.path.name}.")
    write_table(rows, out, overwrite)
    return WorkflowTable(rows, tuple(used), tuple(dict.fromkeys(warnings)))


def correct_leaves(
    project: Project, scan: str, wanted: Wanted, progress: Progress = QUIET
) -> list[str]:
    """Fit and correct the channels of a scan leaf by leaf, or with one fit for all its leaves.

    Returns
    -------
    list of str
        Sentences about leaves that could not be fitted (their points are marked), and about
        doubtful numbers.
    """
    made, warnings = fit_corrections(project, scan, wanted, progress)
    if wanted.fit_to is None:
        return warnings
    if not made:
        raise BadInput("No leaf could be corrected.", " ".join(warnings[-1:]))
    apply_corrections(project, scan, made)
    return warnings


def fit_corrections(
    project: Project, scan: str, wanted: Wanted, progress: Progress = QUIET
) -> tuple[list[Correction], list[str]]:
    """Fit what the corrections of channels need, and keep the fits; puts nothing to use.

    Returns
    -------
    corrections : list of Correction
    warnings : list of str
        Sentences about channels that mean little, about leaves that could not be fitted, and
        about doubtful numbers.
    """
    state = project.state.scan(scan)
    names = wanted.channels or tuple(c.name for c in state.channels if not c.workflow)
    channels = [state.channel(name) for name in names]
    warnings = [text for text in map(warn_about_source, channels) if text]
    if wanted.fit_to is None:
        return [], warnings
    leaves = wanted.leaves
    if leaves is None:
        leaves = tuple(leaf.key for leaf in project.state.leaves_of(scan))
    groups = [leaves] if wanted.fit_to == "all" else [(key,) for key in leaves]
    made: list[Correction] = []
    orders = [(c.name, w, g) for c in channels for w in wanted.workflows for g in groups]
    for number, (channel, workflow, group) in enumerate(orders):
        progress.report(number / len(orders), f"Correcting {channel}")
        model = get_workflow(workflow).model
        try:
            record = fit_leaves(project, scan, group, model, channel)
            meant = () if wanted.fit_to == "all" and wanted.leaves is None else group
            correction = correction_of_fit(
                project, record, workflow, leaves=meant, least_bracket=wanted.least_bracket
            )
            made.append(correction)
            said = " ".join(doubt_correction(correction))
        except BadInput as error:
            said = str(error)
        if said:
            warnings.append(f"{_name(project, group)}, {channel}, {workflow}: {said}")
    return made, warnings


def _name(project: Project, group: Sequence[str]) -> str:
    if len(group) == 1:
        return project.state.leaves[group[0]].name
    return f"{len(group)} leaves" if group else "the whole scan"


def compare_workflows(
    project: Project, scan: str, keys: Sequence[str] | None = None, progress: Progress = QUIET
) -> list[Row]:
    """Leaf × channel: mean, sd, number of points and of marked ones under each workflow.

    Computes nothing but the points of leaves. Channels that are not corrected have WF1 only.
    """
    state = project.state.scan(scan)
    leaves = [leaf for leaf in project.state.leaves_of(scan) if keys is None or leaf.key in keys]
    rows = []
    for number, leaf in enumerate(leaves):
        progress.report(number / len(leaves), "Comparing workflows")
        points = leaf.members.indices[state.alive[leaf.members.indices]]
        for channel in state.channels:
            if not channel.workflow:
                rows.append(compare_points(project, leaf, channel.name, points))
    return rows


def compare_points(project: Project, leaf: Leaf, channel: str, points: Ints) -> Row:
    """One row of `compare_workflows`, for these points of a leaf."""
    state = project.state.scan(leaf.scan)
    row: Row = {"leaf": leaf.key, "name": leaf.name, "channel": channel, "points": len(points)}
    values = project.field(leaf.scan, channel, points)
    row |= _sum_up(CALIBRATED, values, int(np.count_nonzero(~np.isfinite(values))))
    for workflow in state.workflows[1:]:
        name = f"{channel}_{workflow}"
        if any(corrected.name == name for corrected in state.channels):
            marks = project.field(leaf.scan, name + MARK, points)
            values = project.field(leaf.scan, name, points)
            row |= _sum_up(workflow, values, int(np.count_nonzero(marks != GOOD)))
            used = _find(state.parameters.corrections, name, leaf.key)
            row[f"{workflow}_by"] = describe_correction(used) if used else ""
            row[f"{workflow}_words"] = " ".join(doubt_correction(used)) if used else ""
    return row


def _sum_up(workflow: str, values: Floats, marked: int) -> Row:
    known = values[np.isfinite(values)]
    mean = float(known.mean()) if len(known) else None
    sd = float(known.std(ddof=1)) if len(known) > 1 else None
    return {
        f"{workflow}_mean": mean,
        f"{workflow}_sd": sd,
        f"{workflow}_cv": sd / mean if sd is not None and mean else None,
        f"{workflow}_n": len(known),
        f"{workflow}_marked": marked,
    }


def _find(corrections: Sequence[Correction], name: str, leaf: str) -> Correction | None:
    """The correction of a leaf; its own goes before that of all points."""
    own = [c for c in corrections if c.name == name and (leaf in c.leaves or not c.leaves)]
    own.sort(key=lambda c: not c.leaves)
    return own[0] if own else None
