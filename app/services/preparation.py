"""What fields need beside the points when nobody is there to ask: leaves, a curve, a beam."""

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
from app.model.wrinkle_fields import WRINKLES
from app.services.beams import propose_beam
from app.services.curves import DEFAULT_MODEL, fit_leaves, use_fit
from app.services.leaves import find_leaves
from app.services.opening import set_parameters

WARM_UP_POINTS = 64
CURVE_FIELDS = frozenset({"incidence_from_intensity", "delta_omega", "residual"})
WRINKLE_FIELDS = frozenset(spec.name for spec in WRINKLES)
NOTHING_ELSE = frozenset({"leaf", "footprint_share"}) | WRINKLE_FIELDS
"""Fields that without a leaf have no value anywhere."""
LEAF_FIELDS = NOTHING_ELSE | CURVE_FIELDS
BEAM_FIELDS = frozenset({"footprint", "footprint_share"}) | WRINKLE_FIELDS
# What leaves and the curve are made from, beside what the field itself reads.
MADE_FROM = ("ghost",)


def prepare(
    project: Project,
    scan: str,
    fields: Sequence[str],
    parameters: Mapping[str, Any],
    progress: Progress = QUIET,
) -> float:
    """Set parameters, compile what will run, find leaves, curve and beam that are missing.

    Returns
    -------
    float
        Seconds that leaves and curve took, without the fields that they read.
    """
    set_parameters(project, scan, **parameters)
    for name in fields:
        find_spec(project.catalogue(scan), name)
    warm_up(project, scan, fields, progress)
    start, before = time.perf_counter(), _seconds_of_fields(project, scan)
    _find_what_is_missing(project, scan, fields, progress)
    within = _seconds_of_fields(project, scan) - before
    return max(time.perf_counter() - start - within, 0.0)


def needs_preparation(field: str) -> bool:
    """Whether a field rests on leaves or on a curve."""
    return field in LEAF_FIELDS


def warm_up(project: Project, scan: str, fields: Sequence[str], progress: Progress = QUIET) -> None:
    """Compile the kernels that fields will run, on a handful of points, outside any timing."""
    state = project.state.scan(scan)
    few = take_points(state.scan, np.flatnonzero(state.scan.valid)[:WARM_UP_POINTS])
    trial = Project()
    key = trial.shelve(few)
    trial.do(AddScan(key, few.name, None))
    for name in fields:
        progress.report(0.0, "getting ready")
        try:
            _find_what_is_missing(trial, key, (name,), QUIET)
            trial.field(key, name)
        except LeafscopeError:
            continue  # what is missing here is reported by the real computation
    if not {"ghost", "ghost_score", *LEAF_FIELDS}.isdisjoint(fields):
        from app.core.ghosts import warm_up as warm_up_ghosts

        warm_up_ghosts()  # among a few points there may be no doubt, and a kernel stays cold
    if state.scan.grid is None and state.scan.pose is not None:
        _warm_up_recovery(progress)  # a few points have no rows and columns


def _warm_up_recovery(progress: Progress) -> None:
    from app.core.incidence import WAYS, warm_up
    from app.core.neighbours.choice import choose_neighbours

    for way in WAYS:
        progress.report(0.0, "getting ready")
        warm_up(way)

    rise, turn = (a.ravel() for a in np.mgrid[0:0.1:64j, 0:0.1:64j])
    flat = np.cos(rise)
    beams = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)], axis=1)
    choose_neighbours(beams, np.zeros(3), None)


def _find_what_is_missing(
    project: Project, scan: str, fields: Sequence[str], progress: Progress
) -> None:
    state = project.state.scan(scan)
    if BEAM_FIELDS.intersection(fields) and state.parameters.beam is None:
        set_parameters(project, scan, beam=propose_beam(state.scan))
    curve = CURVE_FIELDS.intersection(fields) and not state.parameters.curve
    leaves = project.state.leaves_of(scan)
    if not leaves and (curve or LEAF_FIELDS.intersection(fields)):
        find_leaves(project, scan, progress)
        leaves = project.state.leaves_of(scan)
    if curve:
        # One curve through all leaves; without leaves, through the means of the whole scan.
        keys = tuple(leaf.key for leaf in leaves)
        use_fit(project, fit_leaves(project, scan, keys, DEFAULT_MODEL, None, progress))
    elif NOTHING_ELSE.intersection(fields) and not leaves:
        raise BadInput(
            f"No leaf was found in {project.state.scan(scan).scan.name}.",
            "Label its points and use leaves --label-field, or lasso leaves in the window.",
        )
    if WRINKLE_FIELDS.intersection(fields):
        _measure_wrinkles(project, scan, progress)


def _measure_wrinkles(project: Project, scan: str, progress: Progress) -> None:
    """As the window does when nothing is chosen there: one curve through all leaves."""
    from app.services.wrinkles.fields import fields_of
    from app.services.wrinkles.measure import measure_wrinkles
    from app.services.wrinkles.request import WrinkleRequest

    if any(project.known_field(scan, name) is None for name in WRINKLE_FIELDS):
        found = measure_wrinkles(project, scan, WrinkleRequest(), None, progress)
        project.accept(scan, fields_of(project, scan, found))


def _seconds_of_fields(project: Project, scan: str) -> float:
    return sum(v.seconds.get("own", 0.0) for v in project.cache.known(scan).values())
