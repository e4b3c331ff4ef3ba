"""Scans as a folder of .npy files and one JSON: from the reading process to ours, no pickle."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from app.core.arrays import AnyArray
from app.core.progress import QUIET, Progress
from app.formats.las_waveforms import Descriptor, LasWaveforms
from app.model.scan import Channel, Grid, Pose, Scan

_INDEX = "scans.json"
_BLOCK = 1 << 24  # bytes that are copied between two looks at cancel


def save_scans(scans: list[Scan], folder: Path) -> None:
    """Write scans into an empty folder; names from files never become file names."""
    entries = [_save_scan(scan, folder, str(i)) for i, scan in enumerate(scans)]
    (folder / _INDEX).write_text(json.dumps(entries), encoding="utf-8")


def load_scans(folder: Path, progress: Progress = QUIET) -> list[Scan]:
    """The scans that `save_scans` wrote; arrays are copied to memory, the folder may go."""
    entries = json.loads((folder / _INDEX).read_text(encoding="utf-8"))
    scans = []
    for i, entry in enumerate(entries):
        part = progress.part(i / len(entries), (i + 1) / len(entries))
        scans.append(_load_scan(entry, folder, part))
    return scans


def _save_scan(scan: Scan, folder: Path, prefix: str) -> dict[str, Any]:
    _save(folder, f"{prefix}-xyz", scan.xyz)
    files = {name: f"{prefix}-{i}" for i, name in enumerate(scan.attributes)}
    for name, file in files.items():
        _save(folder, file, scan.attributes[name])
    return {
        "name": scan.name,
        "xyz": f"{prefix}-xyz",
        "attributes": files,
        "channels": [asdict(channel) for channel in scan.channels],
        "pose": None if scan.pose is None else asdict(scan.pose),
        "grid": None if scan.grid is None else _save_grid(scan.grid, folder, prefix),
        "metadata": dict(scan.metadata),
        "warnings": list(scan.warnings),
        "waveforms": _save_waveforms(scan, folder, prefix),
    }


def _save_grid(grid: Grid, folder: Path, prefix: str) -> dict[str, Any]:
    for part in ("row", "column", "no_return"):
        _save(folder, f"{prefix}-{part}", getattr(grid, part))
    return {"rows": grid.rows, "columns": grid.columns, "prefix": prefix}


def _save_waveforms(scan: Scan, folder: Path, prefix: str) -> dict[str, Any] | None:
    """The places of LAS packets; the samples stay in their file."""
    found = scan.waveforms
    if not isinstance(found, LasWaveforms):
        return None
    for name, values in found.columns.items():
        if values is not scan.attributes.get(name):
            _save(folder, f"{prefix}-{name}", values)
    return {
        "path": found.path,
        "size": found.size,
        "modified": found.modified,
        "start": found.start,
        "missing": found.missing,
        "descriptors": {number: asdict(d) for number, d in found.descriptors.items()},
        "columns": {
            name: None if values is scan.attributes.get(name) else f"{prefix}-{name}"
            for name, values in found.columns.items()
        },
    }


def _load_scan(entry: dict[str, Any], folder: Path, progress: Progress) -> Scan:
    xyz = _load(folder, entry["xyz"], progress)
    attributes = {name: _load(folder, file, progress) for name, file in entry["attributes"].items()}
    return Scan(
        name=entry["name"],
        xyz=xyz,
        attributes=attributes,
        channels=tuple(Channel(**channel) for channel in entry["channels"]),
        pose=_load_pose(entry["pose"]),
        grid=_load_grid(entry["grid"], folder, progress),
        metadata=entry["metadata"],
        warnings=tuple(entry["warnings"]),
        waveforms=_load_waveforms(entry["waveforms"], attributes, folder, progress),
    )


def _load_pose(entry: dict[str, Any] | None) -> Pose | None:
    if entry is None:
        return None
    x, y, z = (tuple(axis) for axis in entry["rotation"])
    return Pose(tuple(entry["position"]), (x, y, z), entry["known_by"])


def _load_grid(entry: dict[str, Any] | None, folder: Path, progress: Progress) -> Grid | None:
    if entry is None:
        return None
    row, column, no_return = (
        _load(folder, f"{entry['prefix']}-{part}", progress)
        for part in ("row", "column", "no_return")
    )
    return Grid(entry["rows"], entry["columns"], row, column, no_return)


def _load_waveforms(
    entry: dict[str, Any] | None,
    attributes: dict[str, AnyArray],
    folder: Path,
    progress: Progress,
) -> LasWaveforms | None:
    """The waveforms; columns that are attributes of the scan too are held only once."""
    if entry is None:
        return None
    columns = {
        name: attributes[name] if file is None else _load(folder, file, progress)
        for name, file in entry.pop("columns").items()
    }
    kinds = {int(n): Descriptor(**d) for n, d in entry.pop("descriptors").items()}
    return LasWaveforms(**entry, columns=columns, descriptors=kinds)


def _save(folder: Path, name: str, values: AnyArray) -> None:
    np.save(folder / f"{name}.npy", values, allow_pickle=False)


def _load(folder: Path, name: str, progress: Progress) -> AnyArray:
    """A copy in memory, made in blocks, so that cancel is quick."""
    mapped: AnyArray = np.load(folder / f"{name}.npy", mmap_mode="r", allow_pickle=False)
    values = np.empty(mapped.shape, mapped.dtype)
    rows = max(1, _BLOCK * len(mapped) // max(mapped.nbytes, 1))
    for start in range(0, len(mapped), rows):
        progress.report(0.0, "Taking over the points")
        values[start : start + rows] = mapped[start : start + rows]
    return values
