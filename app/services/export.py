"""Write points with their fields: everything, the selection, or what is not selected."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Literal

import numpy as np

from app import __version__
from app.core.arrays import AnyArray, Ints
from app.core.errors import BadInput, WrongUse
from app.core.progress import QUIET, Progress
from app.formats.cloud import Cloud
from app.formats.saving import save
from app.model.corrections import describe_correction
from app.model.fields import find_spec
from app.model.parameters import Parameters
from app.model.project import Project
from app.model.scan import Scan
from app.services.cleanup.moves import UNITS, describe_moves

# Suffix -> module of `app.formats`, and whether pose and provenance need a sidecar.
WRITERS = {
    ".laz": ("las", True),
    ".las": ("las", True),
    ".e57": ("e57", False),
    ".ptx": ("ptx", True),
    ".ply": ("ply", True),
    ".csv": ("csv_table", True),
    ".npz": ("npz", False),
}
Portion = Literal["everything", "selection", "complement"]


def gather(
    project: Project,
    scan: str,
    fields: Sequence[str],
    portion: Portion = "everything",
    progress: Progress = QUIET,
    traces: bool = False,
) -> Cloud:
    """Collect what is to be written; deleted points never are.

    With `traces` marks and moves of ghosts have columns also where there are none.

    Raises
    ------
    WrongUse
        A field that does not exist.
    BadInput
        There is nothing to write.
    """
    state = project.state.scan(scan)
    rows = chosen_points(project, scan, portion)
    if len(rows) == 0:
        raise BadInput(f"There are no points to export ({portion}) in {state.scan.name}.")
    catalogue = project.catalogue(scan)
    values: dict[str, AnyArray] = {}
    for name in fields:
        if find_spec(catalogue, name).stored:
            continue  # the file's own values travel with the scan, in their own type
        values[name] = as_stored(project.field(scan, name, None, progress), name, project, scan)
    values |= judgements(project, scan, traces)
    units = {name: catalogue[name].unit for name in values if name in catalogue}
    units |= {name: unit for name, unit in UNITS.items() if name in values}
    cloud = Cloud(state.scan, values, units, provenance(project, scan))
    return cloud if len(rows) == len(state.scan) else cloud.subset(rows)


def merge(clouds: Sequence[Cloud]) -> Cloud:
    """One cloud of several, in order, with `scan_index`; pose and grid belong to one scan only."""
    if len(clouds) == 1:
        return clouds[0]
    names = [name for name in clouds[0].columns if all(name in c.columns for c in clouds)]
    columns = {
        name: np.concatenate([cloud.columns[name] for cloud in clouds])
        for name in names
        if name not in ("row", "column")
    }
    sizes = [len(cloud.scan) for cloud in clouds]
    columns["scan_index"] = np.repeat(np.arange(len(clouds), dtype=np.int32), sizes)
    xyz = np.concatenate([cloud.scan.xyz for cloud in clouds])
    first = clouds[0].scan
    merged = Scan(first.name, xyz, columns, first.channels, source=first.source)
    return Cloud(merged, {}, clouds[0].units, {"scans": [dict(c.provenance) for c in clouds]})


def chosen_points(project: Project, scan: str, portion: Portion) -> Ints:
    """Rows of a portion, in file order; points that are not finite belong to everything."""
    state = project.state.scan(scan)
    kept = ~state.deleted
    selected = state.selection.mask(len(state.scan))
    if portion == "selection":
        kept &= selected
    elif portion == "complement":
        kept &= ~selected
    return np.flatnonzero(kept)


def as_stored(values: AnyArray, name: str, project: Project, scan: str) -> AnyArray:
    """Flags as booleans, everything else as it was computed."""
    spec = project.catalogue(scan)[name]
    return values == 1.0 if spec.kind == "flag" else values


def judgements(project: Project, scan: str, traces: bool = False) -> dict[str, AnyArray]:
    """Leaf numbers, ghost marks and moves of ghosts, where there are some."""
    state = project.state.scan(scan)
    found: dict[str, AnyArray] = describe_moves(project, scan, traces)
    if traces or state.marks.any():
        found["ghost_mark"] = state.marks
    leaves = project.state.leaves_of(scan)
    if leaves:
        labels = np.full(len(state.scan), -1, np.int32)
        for leaf in leaves:
            labels[leaf.members.indices] = int(leaf.key.rpartition("-")[2])
        found["leaf_number"] = labels
    return found


def provenance(project: Project, scan: str) -> dict[str, object]:
    """Where exported numbers come from: source, steps, parameters, version."""
    state = project.state.scan(scan)
    source = state.scan.source
    return {
        "written_by": f"leafscope {__version__}",
        "source": None
        if source is None
        else {
            "path": source.path,
            "sha256": source.sha256,
            "scan_index": source.scan_index,
        },
        "steps": [operation.title for operation in project.history.done],
        "parameters": {
            name: getattr(state.parameters, name)
            for name in ("radius", "estimator", "ghost_threshold")
        },
        **_describe_profile(state.parameters),
        **_describe_corrections(state.parameters),
    }


def _describe_profile(parameters: Parameters) -> dict[str, object]:
    if parameters.profile is None:
        return {}
    calibration = {
        "profile": parameters.profile.name,
        "origin": parameters.profile.origin,
        "partial_hits": parameters.partial_hits,
        "powers": {power.channel: [power.value, power.sigma] for power in parameters.powers},
    }
    return {"calibration": calibration}


def _describe_corrections(parameters: Parameters) -> dict[str, object]:
    found: dict[str, object] = {}
    if parameters.corrections:
        found["corrections"] = {
            f"{each.name}{' of ' if each.leaves else ''}{', '.join(each.leaves)}": (
                describe_correction(each)
            )
            for each in parameters.corrections
        }
    if parameters.formulas:
        found["formulas"] = {formula.name: formula.text for formula in parameters.formulas}
    if parameters.synthetic_footprint is not None:
        found["synthetic_footprint"] = parameters.synthetic_footprint
    return found


def export(cloud: Cloud, path: Path, overwrite: bool = False, progress: Progress = QUIET) -> None:
    """Write a cloud in the format that the suffix of `path` names, whole or not at all."""
    refuse_unwritable(path)
    name, sidecar = WRITERS[path.suffix.lower()]
    module = import_module(f"app.formats.{name}")
    save(path, cloud, module.write, overwrite, progress, sidecar)


def refuse_unwritable(path: Path) -> None:
    """Raise `WrongUse` early, before anything is computed, when no format fits the suffix."""
    if path.suffix.lower() not in WRITERS:
        raise WrongUse(
            f"There is no way to write {path.suffix or 'a file without suffix'}.",
            f"Use one of {', '.join(WRITERS)}.",
        )
