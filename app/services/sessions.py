"""Save and open sessions; replay one without a window to the same numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from app.core.errors import BadInput, LeafscopeError, WrongUse
from app.core.fitting import FitResult
from app.core.progress import QUIET, Progress
from app.formats import session as container
from app.formats.atomic import atomic_path, refuse_target
from app.formats.options import ReadOptions
from app.formats.session import Session
from app.formats.sidecar import sidecar_path
from app.model.history import settle
from app.model.leaf import FitRecord
from app.model.operations import AddScan, AnyOperation, PutFit, Several
from app.model.project import Project
from app.model.scan import Scan, Source
from app.model.view_state import ViewState
from app.services.curves import fit_again, plain, result_of
from app.services.export import export, gather
from app.services.leaves import measure_leaves, write_table
from app.services.reading import read_file

CLOSE = 1e-6
"""Relative difference below which a fit came out the same, of its value or its σ."""


def save_session(project: Project, view: ViewState, path: Path, overwrite: bool = True) -> None:
    """Save sources, log and view; an older file stays as ``NAME.bak``.

    Raises
    ------
    BadInput
        A scan that came from no file, or a disk that refuses; the old file is intact.
    """
    sources: dict[str, Source] = {}
    for key in project.state.library:
        source = project.state.library[key].source
        if source is None:
            name = project.state.library[key].name
            raise BadInput(f"{name} came from no file.", "Export it first, then open the export.")
        sources[key] = source
    kept = msgspec.structs.replace(view, previewed=())
    container.write(path, Session(sources, project.history.log, kept), overwrite)
    project.saved_at = project.history.deeds


def open_session(path: Path, progress: Progress = QUIET) -> tuple[Project, ViewState]:
    """Open a session: read its sources again, check them, replay its log.

    Raises
    ------
    BadInput
        The session is damaged, a source is gone, or a source is not the file it was.
    """
    session = container.read(path)
    project = _load_library(path, session, progress)
    try:
        project.restore(session.log)
    except WrongUse as error:
        raise BadInput(f"The session {path.name} is damaged: {error}") from error
    return project, session.view


def _load_library(path: Path, session: Session, progress: Progress) -> Project:
    needed = _needed_sources(path, session)
    project = Project()
    for key, scan in read_sources(path, needed, progress).items():
        project.shelve(scan, key)
    return project


def read_sources(
    path: Path, sources: Mapping[str, Source], progress: Progress = QUIET
) -> dict[str, Scan]:
    """Read the scans of a session, each file once, from where they were or from beside it."""
    scans: dict[str, Scan] = {}
    files: dict[tuple[Path, str], list[Scan]] = {}
    for number, (key, source) in enumerate(sources.items()):
        file = _locate(path, source)
        mark = (file, json.dumps(dict(source.options), sort_keys=True))
        if mark not in files:
            part = progress.part(number / len(sources), (number + 1) / len(sources))
            files[mark] = read_file(file, _options(path, source), part)
        scans[key] = _pick(files[mark], file, source)
    return scans


def _options(path: Path, source: Source) -> ReadOptions:
    try:
        return ReadOptions.from_text(source.options)
    except (TypeError, ValueError, WrongUse) as error:
        raise BadInput(f"The session {path.name} is damaged: {error}.") from error


def _locate(path: Path, source: Source) -> Path:
    for candidate in (Path(source.path), path.parent / Path(source.path).name):
        if candidate.is_file():
            return candidate
    raise BadInput(
        f"The session {path.name} rests on {source.path}, which is not there.",
        f"Put {Path(source.path).name} back, or into the folder of the session.",
    )


def _pick(scans: list[Scan], file: Path, source: Source) -> Scan:
    found = next((s for s in scans if s.source and s.source.scan_index == source.scan_index), None)
    if found is None or found.source is None or found.source.sha256 != source.sha256:
        raise BadInput(
            f"{file} is not the file that the session was made from: its content has changed.",
            "Bring the old file back, or start a new session with the new one.",
        )
    if source.sidecar is not None and found.source.sidecar != source.sidecar:
        raise BadInput(
            f"What lies beside {file} in {sidecar_path(file).name} has changed or is gone; it "
            "held the scanner's position and channels.",
            "Bring the old sidecar back, or start a new session.",
        )
    return replace(found, source=source)


def _needed_sources(path: Path, session: Session) -> dict[str, Source]:
    # A scan whose opening was taken back for good must not be missed.
    done, undone = settle(session.log)
    steps = [step for operation in (*done, *undone) for step in _flatten(operation)]
    needed = {step.scan: step.name for step in steps if isinstance(step, AddScan)}
    for key, name in needed.items():
        if key not in session.sources:
            raise BadInput(f"The session {path.name} is damaged: it lacks {name}.")
    return {key: source for key, source in session.sources.items() if key in needed}


def _flatten(operation: AnyOperation) -> list[AnyOperation]:
    if isinstance(operation, Several):
        return [inner for step in operation.steps for inner in _flatten(step)]
    return [operation]


def replay(
    path: Path, out: Path, overwrite: bool = False, progress: Progress = QUIET
) -> dict[str, Any]:
    """Open a session headless, compute everything anew, and write its tables and points.

    Writes ``SCAN.npz`` (points as the window exports them), ``SCAN-leaves.csv`` and
    ``report.json`` into the folder `out`. The report says whether each stored fit came out
    the same, bit for bit, and which scan could not be coloured as in the window.
    """
    target = out / "report.json"
    refuse_target(target, overwrite, folder_follows=True)
    session = container.read(path)
    project = _load_library(path, session, progress.part(0.0, 0.5))
    fits = replay_log(project, session)
    _make_folder(out)
    steps = [step.title for step in project.history.done]
    report: dict[str, Any] = {"session": str(path), "steps": steps, "scans": [], "fits": fits}
    for key, state in project.state.scans.items():
        if not state.closed:
            progress.report(0.6, state.scan.name)
            report["scans"].append(_replay_scan(project, key, session.view, out, overwrite))
    with atomic_path(target, overwrite) as temporary:
        temporary.write_text(json.dumps(report, indent=2))
    return report


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(
            f"The folder {folder} cannot be made: {error.strerror or error}.", "Choose another one."
        ) from error


def replay_log(project: Project, session: Session) -> list[dict[str, Any]]:
    """Apply what is in force; fit again at its place in the log, and compare."""
    verdicts = []
    done, _ = settle(session.log)
    for operation in done:
        for step in _flatten(operation):
            if isinstance(step, PutFit) and step.fit is not None:
                verdicts.append(_check_fit(project, step.fit))
        project.do(operation)
    return verdicts


def _check_fit(project: Project, record: FitRecord) -> dict[str, Any]:
    again, kept = fit_again(project, record), result_of(record)
    return {
        "fit": record.key,
        "model": record.model,
        "channel": record.channel,
        "leaves": list(record.leaves),
        "result": plain(again),
        "same": _same(again, kept),
    }


def _same(again: FitResult, kept: FitResult) -> bool:
    """Whether two fits agree, but for the order in which a batch adds its numbers."""
    if (again.model, again.n, again.kind) != (kept.model, kept.n, kept.kind):
        return False
    return all(
        math.isclose(value, kept.values[name], rel_tol=CLOSE, abs_tol=CLOSE * _spread(kept, name))
        or (math.isnan(value) and math.isnan(kept.values[name]))
        for name, value in again.values.items()
    )


def _spread(result: FitResult, name: str) -> float:
    return result.parameters[name].sd or 0.0


def _replay_scan(
    project: Project, key: str, view: ViewState, out: Path, overwrite: bool
) -> dict[str, Any]:
    state = project.state.scan(key)
    stem = f"{key}-{_safe(state.scan.name)}"
    points, leaves = out / f"{stem}.npz", out / f"{stem}-leaves.csv"
    refuse_target(points, overwrite)
    refuse_target(leaves, overwrite)
    fields, missing = _colour_of(project, key, view)
    export(gather(project, key, fields), points, overwrite)
    rows = measure_leaves(project, key)
    if rows:
        write_table(rows, leaves, overwrite)
    return {
        "scan": state.scan.name,
        "points": len(state.scan),
        "shown": state.shown,
        "ghosts_marked": int(np.count_nonzero(state.marks > 0)),
        "leaves": len(rows),
        "file": points.name,
        "table": leaves.name if rows else None,
        "missing": missing,
    }


def _colour_of(project: Project, key: str, view: ViewState) -> tuple[list[str], str | None]:
    """The field that colours a scan as a list, empty with the reason where it cannot be had."""
    if not view.colour:
        return [], None
    try:
        project.field(key, view.colour)
    except LeafscopeError as error:
        return [], str(error)
    return [view.colour], None


def _safe(name: str) -> str:
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in name)[:60] or "scan"
