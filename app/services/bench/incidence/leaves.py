"""What the angles of a few leaves cost beside those of the whole scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Floats, Ints
from app.core.incidence import incidence_angle, local_planes
from app.services.bench.incidence.scenes import Truth
from app.services.bench.timing import time_in_turns

LEAVES = 10
TURNS = 5


@dataclass(frozen=True, slots=True)
class LeafCost:
    """Seconds of `LEAVES` leaves and of the whole scan, and the share of points asked for."""

    few: float
    whole: float
    share: float

    @property
    def part(self) -> float:
        """Seconds of the leaves over those of the scan."""
        return self.few / self.whole


def choose_leaves(truth: Truth, count: int = LEAVES) -> Ints:
    """Points of some leaves, spread over their numbers."""
    known = np.unique(truth.leaf[truth.judged])
    chosen = known[np.linspace(0, len(known) - 1, min(count, len(known))).astype(np.int64)]
    return np.flatnonzero(np.isin(truth.leaf, chosen))


def measure_leaves(truth: Truth, xyz: Floats, radius: float) -> LeafCost:
    """Time both, taking turns."""
    few = choose_leaves(truth)

    def run(points: Ints | None) -> None:
        planes = local_planes(xyz, truth.scanner, points, radius, truth.grid)
        incidence_angle(xyz if points is None else xyz[points], planes.normals, truth.scanner)

    rivals = {"few": lambda: run(few), "whole": lambda: run(None)}
    taken = time_in_turns(rivals, TURNS)
    return LeafCost(taken["few"].median, taken["whole"].median, len(few) / len(xyz))
