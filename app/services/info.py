"""What a file holds, as the plain values of ``leafscope info --json``."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.core.arrays import Floats
from app.core.neighbours.asked import as_points
from app.core.neighbours.range_image import build_image
from app.core.neighbours.steps import ScanGrid, UnusableGrid, as_cells
from app.core.normals.image import mark_tiles
from app.core.progress import QUIET, Progress
from app.core.units import to_degrees
from app.model.neighbours import neighbours_of
from app.model.scan import Scan
from app.services.channel_doubts import doubt_channel
from app.services.opening import Opening, open_file, propose_pose


def describe_scans(scans: list[Scan]) -> dict[str, Any]:
    """Points, grid, scanner, channels, bounds and warnings of scans, ready for JSON.

    One scan is described by itself. Several are described together (`grid` and `scanner`
    only where all agree), with one such description each under ``scans``.
    """
    parts = [_describe(scan) for scan in scans]
    if len(parts) == 1:
        return parts[0]
    names = [scan.name for scan in scans]
    return {
        "points": sum(part["points"] for part in parts),
        "grid": _common([part["grid"] for part in parts]),
        "scanner": _common([part["scanner"] for part in parts]),
        "channels": _unique(c for part in parts for c in part["channels"]),
        "bounds": _join([part["bounds"] for part in parts if part["bounds"]]),
        "attributes": _unique(a for part in parts for a in part["attributes"]),
        "details": parts[0]["details"] if parts else {},
        "warnings": _unique(w for part in parts for w in part["warnings"]),
        "scans": [{"name": n, **part} for n, part in zip(names, parts, strict=True)],
    }


def _describe(scan: Scan) -> dict[str, Any]:
    valid = scan.valid
    warnings = list(scan.warnings)
    broken = len(scan) - int(valid.sum())
    if broken:
        warnings.append(f"{broken} points have coordinates that are not finite.")
    channels = [
        {"name": c.name, "wavelength_nm": c.wavelength_nm, "kind": c.kind} for c in scan.channels
    ]
    return {
        "points": len(scan),
        "grid": None if scan.grid is None else [scan.grid.rows, scan.grid.columns],
        "scanner": None if scan.pose is None else list(scan.pose.position),
        "channels": channels,
        "bounds": _bounds(scan.xyz[valid]),
        "attributes": list(scan.attributes),
        "details": dict(scan.metadata),
        "warnings": warnings,
    }


def _bounds(xyz: Floats) -> list[list[float]] | None:
    if len(xyz) == 0:
        return None
    return [xyz.min(axis=0).tolist(), xyz.max(axis=0).tolist()]


def _join(boxes: list[list[list[float]]]) -> list[list[float]] | None:
    return _bounds(np.array(boxes).reshape(-1, 3))


def _common(values: list[Any]) -> Any:
    """The value that all share, or None."""
    return values[0] if values and all(value == values[0] for value in values) else None


def _unique(values: Any) -> list[Any]:
    kept: list[Any] = []
    for value in values:
        if value not in kept:
            kept.append(value)
    return kept


def describe_opened(opening: Opening, progress: Progress = QUIET) -> dict[str, Any]:
    """Describe a file as a command opens it: with the given position and channel names.

    Says besides how neighbours would be found, scan by scan. A gridded scan without pose
    gets a note about the position that its grid speaks for.
    """
    project, keys = open_file(opening, progress.part(0.0, 0.6))
    scans = [project.state.scan(key).scan for key in keys]
    found = describe_scans(scans)
    found["neighbours"] = [_describe_neighbours(scan, progress.part(0.6, 1.0)) for scan in scans]
    found["warnings"] += [note for scan in scans if (note := _propose(scan))]
    found["warnings"] += _unique(note for scan in scans if (note := doubt_channel(scan)))
    return found


def _describe_neighbours(scan: Scan, progress: Progress) -> dict[str, Any]:
    """How neighbours would be found; the steps (down, across) where there are rows and columns."""
    chosen = neighbours_of(scan, progress)
    method, reason, step = chosen.method, chosen.reason, None
    if chosen.grid is not None and scan.pose is not None:
        try:
            step = _measure_step(scan, chosen.grid)
        except UnusableGrid as refusal:
            method, reason = "voxel hash", str(refusal)
    return {"scan": scan.name, "method": method, "reason": reason, "step_deg": step}


def _measure_step(scan: Scan, grid: ScanGrid) -> list[float]:
    """The same test that angles make, so that it is refused here where it is refused there."""
    cells = as_cells(grid)
    tiles = mark_tiles(cells, np.empty(0, np.int64))[1]
    beams = build_image(as_points(scan.xyz), scan.scanner("its steps"), cells, tiles).beams
    steps = np.median(np.abs(beams.down)), np.median(np.abs(beams.turn)) * np.median(beams.level)
    return [float(to_degrees(step)) for step in steps]


def _propose(scan: Scan) -> str:
    pose = propose_pose(scan)
    if pose is None:
        return ""
    x, y, z = pose.position
    return (
        f"{scan.name} states no scanner position; its rows and columns fit one at "
        f"{x:g},{y:g},{z:g}. Give --origin {x:g},{y:g},{z:g} to accept it."
    )
