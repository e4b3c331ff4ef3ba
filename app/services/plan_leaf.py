"""A leaf of a scan in the terms of a plan: how far it is, how long and how wide."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from app.core.arrays import Ints
from app.core.errors import BadInput
from app.model.state import ScanState


class SeenLeaf(NamedTuple):
    """Median range, length and width, metres."""

    distance: float
    length: float
    width: float


QUARTER = 0.403973
"""Of the half axis: within ± this of the middle lies half of an ellipse."""
THICK = 0.004
"""Metres from the plane within which a point is leaf in any case: leaves are bent."""
THIN = 1e-6
"""Of its length a leaf must be wider than this, or its points lie on a line."""
LEAST = 20
"""Points from which on a size means something."""


def measure_leaf(state: ScanState, members: Ints) -> SeenLeaf:
    """Range and size of a leaf, the size as of a flat ellipse.

    Points far from a robust plane are left out. Half axes come from the middle half of the
    others along the directions in which they spread most and least: unlike the outermost
    points, ghosts at the border hardly move these.

    Raises
    ------
    BadInput
        It has few living points, or they lie on a line.
    MissingScanner
        Nobody told where the scanner stood.
    """
    from app.core.robust_plane import robust_normal

    scanner = state.scan.scanner("the range of a leaf")
    xyz = state.scan.xyz[members[state.alive[members]]]
    if len(xyz) < LEAST:
        raise BadInput(f"The leaf has only {len(xyz)} points.", f"Choose one with {LEAST} or more.")
    middle = np.median(xyz, axis=0)
    spread = np.linalg.svd(xyz - xyz.mean(axis=0), compute_uv=False)
    if not spread[1] > THIN * spread[0]:
        raise BadInput("The leaf's points lie on a line: it has no width.")
    _, near = robust_normal(xyz - middle, THICK)
    # Of points near a plane the two directions of the largest spread lie in it.
    kept = xyz[near] - middle
    _, _, axes = np.linalg.svd(kept - kept.mean(axis=0), full_matrices=False)
    low, high = np.quantile(kept @ axes[:2].T, (0.25, 0.75), axis=0)
    short, long = np.sort((high - low) / QUARTER)
    distance = float(np.median(np.linalg.norm(xyz[near] - scanner, axis=1)))
    return SeenLeaf(distance, float(long), float(short))


def range_of(state: ScanState, row: int) -> float:
    """Range of a point, metres; raises `MissingScanner`."""
    scanner = state.scan.scanner("the range of a point")
    return float(np.linalg.norm(state.scan.xyz[row] - scanner))
