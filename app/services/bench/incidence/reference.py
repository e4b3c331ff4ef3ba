"""The same ball by a k-d tree and numpy's eigen solver, for the angles that must be equal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.incidence import incidence_angle, local_planes
from app.core.units import to_degrees
from app.services.bench.incidence.scenes import Truth

SAMPLE = 4_000
SHARP = 10.0
"""Times by which the two smallest eigenvalues must differ, or the plane is anybody's guess."""


@dataclass(frozen=True, slots=True)
class Equality:
    """Largest difference of the angle, degrees, over the points that could be compared."""

    worst: float
    compared: int
    asked: int


def compare_with_tree(truth: Truth, xyz: Floats, radius: float, grid: bool) -> Equality:
    """Our total least squares in a ball beside a brute-force one, where both see the same points.

    Points count where the number of neighbours agrees, all but those on the rim of a ball.
    """
    random = np.random.default_rng(0)
    judged = np.flatnonzero(truth.judged)
    asked = np.sort(random.choice(judged, min(SAMPLE, len(judged)), replace=False))
    cells = truth.grid if grid else None
    planes = local_planes(xyz, truth.scanner, asked, radius, cells, estimator="ball")
    normals, count = fit_balls(xyz, asked, planes.width.astype(np.float64))
    angles = (
        to_degrees(incidence_angle(xyz[asked], found, truth.scanner))
        for found in (planes.normals, normals)
    )
    off = np.abs(np.subtract(*angles))
    same = (count == planes.count) & np.isfinite(off)
    return Equality(float(off[same].max(initial=0.0)), int(same.sum()), len(asked))


def fit_balls(xyz: Floats, asked: Ints, widths: Floats) -> tuple[Floats, Ints]:
    """Normals and numbers of neighbours of balls, one radius each; NaN where not sharp."""
    from scipy.spatial import cKDTree

    tree = cKDTree(xyz)
    normals, count = np.full((len(asked), 3), np.nan), np.zeros(len(asked), np.int64)
    balls = tree.query_ball_point(xyz[asked], widths, workers=-1)
    for k, (point, members) in enumerate(zip(asked, balls, strict=True)):
        offsets = xyz[members] - xyz[point]
        offsets -= offsets.mean(axis=0)
        values, vectors = np.linalg.eigh(offsets.T @ offsets)
        count[k] = len(members)
        if len(members) >= 3 and values[1] > SHARP * max(values[0], 0.0):
            normals[k] = vectors[:, 0]
    return normals, count
