"""Compute fields of a file and write them, with a report of what it cost."""

from __future__ import annotations

import platform
import time
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_target
from app.model.operations import SetParameters
from app.model.project import Project
from app.services.beams import describe_beam
from app.services.corrections import tell_corrections
from app.services.export import export, gather, merge, refuse_unwritable
from app.services.formulas import tell_picks
from app.services.opening import Opening, open_file
from app.services.preparation import BEAM_FIELDS, MADE_FROM, needs_preparation, prepare
from app.services.radiometry import tell_calibration

VERSIONED = ("leafscope", "numpy", "scipy", "numba")


def compute_file(
    opening: Opening,
    fields: Sequence[str],
    out: Path,
    parameters: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    progress: Progress = QUIET,
) -> dict[str, Any]:
    """Read a file, compute fields for every point, write them in file order.

    Parameters
    ----------
    fields : sequence of str
        Names of fields; those that need leaves or a curve get leaves found by connectivity
        and one curve fitted to all of them, and the report says so.
    out : Path
        A file whose suffix names a format that can be written.
    parameters : mapping
        Attributes of `Parameters` that differ from the defaults.

    Returns
    -------
    dict
        The report: seconds, parts, computed, undefined, notes, warnings, versions.
    """
    refuse_unwritable(out)
    refuse_target(out, overwrite, sources=[opening.path])
    start = time.perf_counter()
    project, keys = open_file(opening, progress.part(0.0, 0.4))
    read = time.perf_counter() - start
    prepared, opened = 0.0, len(project.history.done)
    for key in keys:
        prepared += prepare(project, key, fields, parameters or {}, progress.part(0.4, 0.5))
        for name in fields:
            project.field(key, name, None, progress.part(0.5, 0.9))
    start = time.perf_counter()
    export(merge([gather(project, key, fields) for key in keys]), out, overwrite, progress)
    report = make_report(project, keys, fields, prepared)
    made = [s for s in project.history.done[opened:] if not isinstance(s, SetParameters)]
    report["warnings"] += [f"Done for you: {step.title}." for step in made]
    if not BEAM_FIELDS.isdisjoint(fields):
        report["warnings"] += _tell_beams(project, keys)
    for tell in (tell_calibration, tell_corrections, tell_picks):
        report["warnings"] += [line for key in keys for line in tell(project, key, fields)]
    write = time.perf_counter() - start
    report["seconds"] = {"read": read, **report["seconds"], "write": write}
    return report


def _tell_beams(project: Project, keys: Sequence[str]) -> list[str]:
    beams = [project.state.scan(key).parameters.beam for key in keys]
    return list(dict.fromkeys(f"Beam: {describe_beam(beam)}." for beam in beams if beam))


def make_report(
    project: Project, keys: Sequence[str], fields: Sequence[str], prepared: float = 0.0
) -> dict[str, Any]:
    """Seconds per field (all that it needed), points computed, undefined values, versions.

    `prepared` are the seconds that leaves and curve took; fields that rest on them count it.
    """
    report: dict[str, Any] = {
        "seconds": dict.fromkeys(fields, 0.0),
        "parts": {},
        "computed": {},
        "undefined": dict.fromkeys(fields, 0),
        "notes": {},
        "warnings": [],
        "versions": versions(),
    }
    for key in keys:
        _report_scan(project, key, fields, report)
    for name in filter(needs_preparation, fields):
        report["seconds"][name] += prepared
        report["parts"][name]["leaves and curve"] = prepared
    return report


def _report_scan(project: Project, key: str, fields: Sequence[str], report: dict[str, Any]) -> None:
    known = project.cache.known(key)
    state = project.state.scan(key)
    for name in fields:
        parts = seconds_of(project, key, name)
        for other in MADE_FROM if needs_preparation(name) else ():
            parts |= seconds_of(project, key, other)
        report["seconds"][name] += sum(parts.values())
        report["undefined"][name] += int(
            np.count_nonzero(~np.isfinite(known[name].values) & state.scan.valid)
        )
        for part, seconds in {**parts, **_stages(project, key, name)}.items():
            held = report["parts"].setdefault(name, {})
            held[part] = held.get(part, 0.0) + seconds
    for name, count in project.cache.computed(key).items():
        report["computed"][name] = report["computed"].get(name, 0) + count
        _add_notes(report["notes"].setdefault(name, {}), known[name].notes if name in known else {})
    report["warnings"] += [w for w in state.scan.warnings if w not in report["warnings"]]


def _add_notes(held: dict[str, Any], notes: Mapping[str, Any]) -> None:
    """Add the notes of one more scan; where scans differ, a note becomes a list of all."""
    for name, note in notes.items():
        if name not in held:
            held[name] = note
        elif isinstance(held[name], list):
            held[name] = [*held[name], note]
        elif held[name] != note:
            held[name] = [held[name], note]


def seconds_of(project: Project, scan: str, field: str) -> dict[str, float]:
    """Seconds of a field and of every field it rests on, each without the others."""
    spec = project.catalogue(scan)[field]
    known = project.cache.known(scan)
    parts = {field: known[field].seconds.get("own", 0.0)} if field in known else {}
    for name in spec.inputs:
        parts |= seconds_of(project, scan, name)
    return parts


def _stages(project: Project, scan: str, field: str) -> dict[str, float]:
    seconds = project.cache.known(scan)[field].seconds
    return {f"{field}.{stage}": value for stage, value in seconds.items() if stage != "own"}


def versions() -> dict[str, str]:
    """Versions of what the numbers came from."""
    return {"python": platform.python_version(), **{name: version(name) for name in VERSIONED}}
