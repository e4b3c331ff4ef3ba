"""What fields need beside the points when nobody is there to ask: leaves and a curve."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from app.core.errors import BadInput, LeafscopeError
from app.core.progress import QUIET, Progress
from app.formats.cloud import take_points
from app.model.fields import find_spec
from app.model.operations import AddScan
from app.model.project import Project
from app.services.curves import DEFAULT_MODEL, fit_leaves, use_fit
from app.services.leaves import find_leaves
from app.services.opening import set_parameters

WARM_UP_POINTS = 64
CURVE_FIELDS = frozenset({"incidence_from_intensity", "delta_omega"})
LEAF_FIELDS = frozenset({"leaf"}) | CURVE_FIELDS
# What leaves and the curve are made from, beside what the field itself reads.
MADE_FROM = ("ghost",)


def prepare(
    project: Project,
    scan: str,
    fields: Sequence[str],
    parameters: Mapping[str, Any],
    progress: Progress = QUIET,
) -> float:
    """Set parameters, compile what will run, find leaves and fit the curve that are missing.

    Returns
    -------
    float
        Seconds that leaves and curve took, without the fields that they read.
    """
    set_parameters(project, scan, **parameters)
    for name in fields:
        find_spec(project.catalogue(scan), name)
    warm_up(project, scan, fields)
    start, before = time.perf_counter(), _seconds_of_fields(project, scan)
    _find_what_is_missing(project, scan, fields, progress)
    within = _seconds_of_fields(project, scan) - before
    return max(time.perf_counter() - start - within, 0.0)


def needs_preparation(field: str) -> bool:
    """Whether a field rests on leaves or on a curve."""
    return field in LEAF_FIELDS


def warm_up(project: Project, scan: str, fields: Sequence[str]) -> None:
    """Compile the kernels that fields will run, on a handful of points, outside any timing."""
    state = project.state.scan(scan)
    few = take_points(state.scan, np.flatnonzero(state.scan.valid)[:WARM_UP_POINTS])
    trial = Project()
    key = trial.shelve(few)
    trial.do(AddScan(key, few.name, None))
    for name in fields:
        try:
            _find_what_is_missing(trial, key, (name,), QUIET)
            trial.field(key, name)
        except LeafscopeError:
            continue  # what is missing here is reported by the real computation
    if not {"ghost", "ghost_score", *LEAF_FIELDS}.isdisjoint(fields):
        from app.core.ghosts import warm_up as warm_up_ghosts

        warm_up_ghosts()  # among a few points there may be no doubt, and a kernel stays cold


def _find_what_is_missing(
    project: Project, scan: str, fields: Sequence[str], progress: Progress
) -> None:
    curve = CURVE_FIELDS.intersection(fields) and not project.state.scan(scan).parameters.curve
    leaves = project.state.leaves_of(scan)
    if not leaves and (curve or LEAF_FIELDS.intersection(fields)):
        find_leaves(project, scan, progress)
        leaves = project.state.leaves_of(scan)
    if curve:
        # One curve through all leaves; without leaves, through the means of the whole scan.
        keys = tuple(leaf.key for leaf in leaves)
        use_fit(project, fit_leaves(project, scan, keys, DEFAULT_MODEL, None, progress))
    elif "leaf" in fields and not leaves:
        raise BadInput(
            f"No leaf was found in {project.state.scan(scan).scan.name}.",
            "Label its points and use leaves --label-field, or lasso leaves in the window.",
        )


def _seconds_of_fields(project: Project, scan: str) -> float:
    return sum(v.seconds.get("own", 0.0) for v in project.cache.known(scan).values())
