"""What others do: each gives a score, larger is more of a ghost, and has a usual setting.

A peer is judged at its usual setting and, to its favour, at the best of all there are for each
scene. All are as anyone would write them on SciPy's k-d tree, or on the grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.units import to_degrees
from app.model.scan import Scan
from app.services.bench.ghosts.truth import cells_of, ranges_of

SOR, RADIUS, STRAY, ANGLE = "statistical outlier", "radius outlier", "stray window", "incidence"
SLOW_TREE = "8 neighbours, SciPy's usual tree"
SOR_FAST = (f"{SOR}, 8 neighbours", f"{SOR}, {SLOW_TREE}")
"""The outlier removals that our time is compared with."""


@dataclass(frozen=True, slots=True)
class Rival:
    """A way to score points.

    Attributes
    ----------
    family : str
        What it is known as.
    variant : str
        What has to be chosen before it runs.
    usual : float
        Its usual setting: points with a score from there on are called ghosts.
    unit : str
        Of the setting.
    score : callable
        Of a scan; (n,) floats.
    """

    family: str
    variant: str
    usual: float
    unit: str
    score: Callable[[Scan], Floats]

    @property
    def name(self) -> str:
        """Unlike any other."""
        return f"{self.family}, {self.variant}"


def list_rivals() -> tuple[Rival, ...]:
    """All peers.

    Their usual settings: 1 σ above the mean distance (CloudCompare, PCL); 16 neighbours within
    the radius that a full surface fills with 50; half of a window (FARO SCENE); 80° of incidence.
    """
    return (
        *(
            Rival(SOR, f"{k} neighbours", 1.0, "σ", partial(score_outliers, count=k))
            for k in (8, 16)
        ),
        Rival(SOR, SLOW_TREE, 1.0, "σ", partial(score_outliers, count=8, balanced=True)),
        *(
            Rival(RADIUS, f"{k} neighbours", 4.0, "spacings", partial(score_sparse, count=k))
            for k in (4, 8, 16)
        ),
        Rival(STRAY, "7 × 7, 1 cm", 0.5, "of the window", partial(score_stray, half=3, gate=0.01)),
        Rival(STRAY, "5 × 5, 2 cm", 0.5, "of the window", partial(score_stray, half=2, gate=0.02)),
        Rival(ANGLE, "nearer beams", 80.0, "°", score_step_angle),
        Rival(ANGLE, "3 × 3 beams", 80.0, "°", partial(score_window_angle, half=1)),
        Rival(ANGLE, "16 neighbours", 80.0, "°", partial(score_angle, count=16)),
    )  # fmt: skip


def score_outliers(scan: Scan, count: int, balanced: bool = False) -> Floats:
    """Mean distance to the nearest points, in σ above the mean of all.

    `balanced`: on the tree that SciPy makes when it is not asked for another, which is slower.
    """
    mean = _nearest(scan.xyz, count, balanced)[0].mean(axis=1)
    score: Floats = (mean - mean.mean()) / mean.std()
    return score


def score_sparse(scan: Scan, count: int) -> Floats:
    """Radius within which there are that many other points, in units of the usual spacing.

    Fewer than `count` within r is the same as the one of that number beyond r: one search
    answers for all radii. The spacing is the median distance to the nearest point.
    """
    away = _nearest(scan.xyz, count)[0]
    score: Floats = away[:, -1] / np.median(away[:, 0])
    return score


def score_stray(scan: Scan, half: int, gate: float) -> Floats:
    """Share of the window's other points that lie farther than `gate` in range."""
    cells, own = cells_of(scan), ranges_of(scan)
    image = np.full((cells.rows + 2 * half, cells.columns + 2 * half), np.nan)
    image[cells.row + half, cells.column + half] = own
    near, there = np.full(len(own), -1), np.full(len(own), -1)
    for down in range(2 * half + 1):
        for across in range(2 * half + 1):
            off = np.abs(image[cells.row + down, cells.column + across] - own)
            near += off <= gate
            there += ~np.isnan(off)
    return np.where(there > 0, 1.0 - near / np.maximum(there, 1), 1.0)


def score_angle(scan: Scan, count: int) -> Floats:
    """Angle of incidence, degrees, on the plane through a point and those nearest to it."""
    places = _nearest(scan.xyz, count)[1]
    relative = scan.xyz - scan.scanner("ghost points")
    angle = np.empty(len(relative))
    for first in range(0, len(relative), 200_000):
        part = slice(first, first + 200_000)
        around = np.concatenate([relative[part, None], relative[places[part]]], axis=1)
        around -= around.mean(axis=1, keepdims=True)
        angle[part] = _incidence(np.einsum("nki,nkj->nij", around, around), relative[part])
    return angle


def score_window_angle(scan: Scan, half: int) -> Floats:
    """Angle of incidence, degrees, on the plane through the points of the window around.

    90° where the window holds fewer than three points.
    """
    cells, relative = cells_of(scan), scan.xyz - scan.scanner("ghost points")
    image = np.zeros((4, cells.rows + 2 * half, cells.columns + 2 * half))
    image[0, cells.row + half, cells.column + half] = 1.0
    image[1:, cells.row + half, cells.column + half] = relative.T
    count, total, square = (
        np.zeros(len(relative)),
        np.zeros((len(relative), 3)),
        np.zeros((len(relative), 3, 3)),
    )
    for down in range(2 * half + 1):
        for across in range(2 * half + 1):
            there, *place = image[:, cells.row + down, cells.column + across]
            # About the point itself: squares of metres would drown millimetres.
            off = (np.array(place).T - relative) * there[:, None]
            count += there
            total += off
            square += off[:, :, None] * off[:, None, :]
    square -= total[:, :, None] * total[:, None, :] / count[:, None, None]
    return np.where(count >= 3.0, _incidence(square, relative), 90.0)


def score_step_angle(scan: Scan) -> Floats:
    """Angle of incidence, degrees, on the plane of two steps: one along the row, one down.

    Of the two beams beside a point the one nearer in range is taken, so that a border is no steep
    surface; 90° where there is none.
    """
    cells, relative = cells_of(scan), scan.xyz - scan.scanner("ghost points")
    image = np.full((cells.rows + 2, cells.columns + 2, 3), np.nan)
    image[cells.row + 1, cells.column + 1] = relative
    own = np.linalg.norm(relative, axis=1)
    steps = []
    for down, across in ((1, 0), (0, 1)):
        sides = [
            image[cells.row + 1 + way * down, cells.column + 1 + way * across] for way in (-1, 1)
        ]
        jumps = [np.abs(np.linalg.norm(side, axis=1) - own) for side in sides]
        first = np.nan_to_num(jumps[0], nan=np.inf) <= np.nan_to_num(jumps[1], nan=np.inf)
        steps.append(np.where(first[:, None], sides[0], sides[1]) - relative)
    normal = np.cross(*steps)
    cosine = np.abs((normal * relative).sum(axis=1)) / (np.linalg.norm(normal, axis=1) * own)
    angle: Floats = np.nan_to_num(to_degrees(np.arccos(np.clip(cosine, 0.0, 1.0))), nan=90.0)
    return angle


def _nearest(xyz: Floats, count: int, balanced: bool = False) -> tuple[Floats, Ints]:
    """Distances to, and places of, the nearest other points, (n, count)."""
    from scipy.spatial import cKDTree

    # Sliding midpoints instead of medians: on scans twice as quick.
    tree = cKDTree(xyz, balanced_tree=balanced)
    away, place = tree.query(xyz, count + 1, workers=-1)
    return np.asarray(away)[:, 1:], np.asarray(place)[:, 1:]


def _incidence(scatter: AnyArray, relative: Floats) -> Floats:
    """Angle between beams and the direction in which points scatter least, degrees."""
    normal = np.linalg.eigh(scatter)[1][:, :, 0]
    cosine = np.abs((normal * relative).sum(axis=1)) / np.linalg.norm(relative, axis=1)
    return np.asarray(to_degrees(np.arccos(np.clip(cosine, 0.0, 1.0))))
