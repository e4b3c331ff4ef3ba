"""Which methods run at which radii on a scan, and how often."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.incidence import local_planes
from app.core.progress import QUIET, Progress
from app.services.bench.incidence.peers import (
    CLOUDCOMPARE,
    OPEN3D,
    SCIPY,
    Peer,
    cloudcompare_rival,
    open3d_rival,
    scipy_rival,
)
from app.services.bench.incidence.rivals import RADII, Load, Rival, our_rival, single_rival
from app.services.bench.incidence.scenes import CLEAN, USUAL, make_plane
from app.services.bench.timing import time_in_turns

TURNS = 3
QUICK_RADII = (0.004, 0.006)
LARGE = 1_000_000
"""Points of a scan on which the slow ones run under one noise only."""
SAMPLE = 5_000
"""Points that tell how many neighbours a ball has."""


@dataclass(frozen=True, slots=True)
class Field:
    """Who takes part, whatever the scan.

    Attributes
    ----------
    radius : float
        Metres; the figures of the issue are at this one.
    peers : tuple of Peer
        Programs of others; none without --peers.
    quick : bool
    """

    radius: float
    peers: tuple[Peer, ...]
    quick: bool

    @property
    def radii(self) -> tuple[float, ...]:
        """All radii, the given one among them."""
        return tuple(sorted({*(QUICK_RADII if self.quick else RADII), self.radius}))

    @property
    def others(self) -> tuple[float, ...]:
        """All radii but the given one."""
        return tuple(radius for radius in self.radii if radius != self.radius)

    def find(self, program: str) -> str:
        """Where a peer was found; empty where it is missing or not asked."""
        return next((peer.found for peer in self.peers if peer.program == program), "")


def run_all(load: Load, field: Field, progress: Progress = QUIET) -> list[Rival]:
    """Run all methods on a load: those of the given radius in turns, the slow rest once."""
    first, rest = _choose_first(load, field), _choose_rest(load, field)
    turns = 1 if field.quick else TURNS
    time_in_turns({r.name: r.run for r in first}, turns, progress.part(0.0, 0.5))
    time_in_turns({r.name: r.run for r in rest}, 1, progress.part(0.5, 1.0))
    return [*first, *rest]


def _choose_first(load: Load, field: Field) -> list[Rival]:
    """Ours that are quick at any radius, and everybody's search at the given one."""
    chosen = [
        our_rival(load, name, radius) for name in ("adaptive", "window") for radius in field.radii
    ]
    chosen.append(our_rival(load, "robust", field.radius))
    chosen += [our_rival(load, "ball", field.radius, grid) for grid in (True, False)]
    if field.find(OPEN3D):
        chosen.append(open3d_rival(load, field.radius))
    return chosen


def _choose_rest(load: Load, field: Field) -> list[Rival]:
    """Balls of other radii, single precision, and peers that are far from the fastest.

    A ball's time grows with the square of its radius: on large scans one noise must be enough,
    and on the clean one Open3D's other radii are left out.
    """
    radius, usual = field.radius, load.noise == USUAL
    chosen = [single_rival(load, "adaptive", radius), single_rival(load, "ball", radius)]
    if usual or len(load.xyz) < LARGE:
        chosen += [our_rival(load, "ball", other) for other in field.others]
        if load.truth.name != CLEAN:
            chosen += [our_rival(load, "ball", other, grid=False) for other in field.others]
            if field.find(OPEN3D):
                chosen += [open3d_rival(load, other) for other in field.others]
    return chosen + (_choose_usual(load, field) if usual else [])


def _choose_usual(load: Load, field: Field) -> list[Rival]:
    """Peers of which one noise tells enough; on large scans only those that take no minutes."""
    chosen: list[Rival] = []
    if program := field.find(CLOUDCOMPARE):
        chosen.append(cloudcompare_rival(load, field.radius, program))
    if len(load.xyz) >= LARGE:
        return chosen
    if field.find(OPEN3D):
        most = count_neighbours(load, field.radius)
        for search in ("knn", "hybrid"):
            chosen.append(open3d_rival(load, field.radius, search, most))
    if field.find(SCIPY):
        chosen.append(scipy_rival(load, field.radius))
    return chosen


def count_neighbours(load: Load, radius: float) -> int:
    """Median number of points in the ball of a judged point."""
    judged = np.flatnonzero(load.truth.judged)
    some = judged[:: max(1, len(judged) // SAMPLE)]
    truth = load.truth
    planes = local_planes(load.xyz, truth.scanner, some, radius, truth.grid, estimator="ball")
    return int(np.median(planes.count))


def warm_up(field: Field) -> None:
    """Run everything once on a few points, so that nothing is compiled while a clock runs."""
    truth = make_plane(30.0, 60)
    load = Load(truth, USUAL, truth.add_noise(USUAL))
    rivals = [*_choose_first(load, field), *_choose_usual(load, field)]
    time_in_turns({rival.name: rival.run for rival in rivals}, 1)
