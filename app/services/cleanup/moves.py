"""What a file says of corrected ghosts: how far each was moved, and how sure it lies right there.

``measured = xyz - (ghost_moved_x, ghost_moved_y, ghost_moved_z)``: whoever reads the file tells
moved points from measured ones, and puts them back, without knowing where the scanner stood.
"""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints, finite_rows
from app.core.units import to_mm
from app.model.project import Project
from app.model.scan import Scan

MOVED, CONFIDENCE = "ghost_moved", "ghost_moved_confidence"
AXES = tuple(f"{MOVED}_{axis}" for axis in "xyz")
UNITS = {MOVED: "mm", CONFIDENCE: "", **dict.fromkeys(AXES, "m")}


def describe_moves(project: Project, scan: str, always: bool = False) -> dict[str, AnyArray]:
    """Columns of `UNITS`, (n,) float32 each; none where no point was moved, unless `always`.

    The distance is signed along the beam, positive away from the scanner, and 0 where a point
    is as it was measured; there the confidence is NaN. What a file tells of earlier moves of its
    points counts too.
    """
    state = project.state.scan(scan)
    read = project.state.library[scan]
    rows = _find_moved(state.scan.xyz, read.xyz)
    earlier = _read_earlier(read)
    if not (always or len(rows) or earlier is not None):
        return {}
    moved = np.zeros((len(read), 3)) if earlier is None else earlier
    moved[rows] += state.scan.xyz[rows] - read.xyz[rows]
    confidence = np.full(len(read), np.nan, np.float32)
    if CONFIDENCE in read.attributes:
        confidence = read.attributes[CONFIDENCE].astype(np.float32)
    if state.confidence is not None:
        confidence[rows] = state.confidence[rows]
    columns = {MOVED: to_mm(_measure(state.scan, moved)), CONFIDENCE: confidence}
    columns |= dict(zip(AXES, moved.T, strict=True))
    return {name: values.astype(np.float32) for name, values in columns.items()}


def _find_moved(now: Floats, before: Floats) -> Ints:
    if now is before:
        return np.empty(0, np.int64)
    return np.flatnonzero((now != before).any(axis=1) & finite_rows(now) & finite_rows(before))


def _read_earlier(scan: Scan) -> Floats | None:
    """Where the points of a file that was written so were moved before, (n, 3) metres."""
    if not set(AXES) <= set(scan.attributes):
        return None
    earlier: Floats = np.stack([scan.attributes[name] for name in AXES], axis=1).astype(np.float64)
    return np.nan_to_num(earlier)


def _measure(scan: Scan, moved: Floats) -> Floats:
    """Length, negative for a move towards the scanner; unsigned where nobody knows where it is."""
    length: Floats = np.zeros(len(moved))
    rows = np.flatnonzero(moved.any(axis=1))
    length[rows] = np.linalg.norm(moved[rows], axis=1)
    if scan.pose is not None:
        beams = scan.xyz[rows] - scan.scanner("the moves of ghosts")
        nearer = np.einsum("ij,ij->i", moved[rows], beams) < 0.0
        length[rows[nearer]] *= -1.0
    return length
