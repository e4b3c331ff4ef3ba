"""Areas of all leaves of a case, by our way and by those of others."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

from app.core.arrays import Bools, Ints
from app.core.errors import BadInput
from app.core.mesh import mesh_leaf
from app.services.bench.area.measures import FEWEST, Measured
from app.services.bench.area.rivals import delaunay_area, hull_area, keep_inliers
from app.services.bench.area.scenes import Case

STEEPEST, SEEN = 60.0, 0.95
OURS = "mesh"
RIVALS = ("Delaunay", "convex hull", "Delaunay after SOR", "convex hull after SOR")
Found = dict[str, list[Measured]]


def is_judged(case: Case, number: int, points: Ints) -> bool:
    """Whether figures are told of a leaf: full hits, not steep, seen (as far as it is known)."""
    leaf = case.leaves[number]
    if int(case.full[points].sum()) < FEWEST or not leaf.omega < STEEPEST:
        return False
    return not leaf.seen < SEEN  # NaN: of another simulator; our own word on it decides


def measure_case(
    case: Case, members: Mapping[int, Ints], ghosts: Bools, beam: tuple[float, float] | None,
    seconds: dict[str, float], told: bool = True,
) -> Found:  # fmt: skip
    """Errors by way; `members` holds the points of each leaf as some cleaning left them."""
    found: Found = {name: [] for name in (OURS, *RIVALS)}
    for number, points in members.items():
        if not is_judged(case, number, points):
            continue
        true = case.leaves[number]
        start = time.perf_counter()
        try:
            area = mesh_leaf(case.layout, points, ghosts, beam, told).area
        except BadInput:
            found[OURS].append(Measured(true.kind, -1.0, False, 0.0))
            continue
        seconds[OURS] = seconds.get(OURS, 0.0) + time.perf_counter() - start
        if np.isnan(true.seen) and not area.whole:
            continue
        held = area.low <= true.area <= area.high
        width = (area.high - area.low) / 2 / true.area
        found[OURS].append(Measured(true.kind, area.value / true.area - 1, held, width))
        _measure_rivals(case, points, true.kind, true.area, seconds, found)
    return found


def _measure_rivals(
    case: Case, points: Ints, kind: str, area: float, seconds: dict[str, float], found: Found
) -> None:
    xyz = case.layout.xyz[points]
    start = time.perf_counter()
    inliers = xyz[keep_inliers(xyz)]
    cleaning = time.perf_counter() - start
    for name in RIVALS:
        after = name.endswith("SOR")
        start = time.perf_counter()
        way = hull_area if "hull" in name else delaunay_area
        value = way(inliers if after else xyz)
        taken = time.perf_counter() - start + (cleaning if after else 0.0)
        seconds[name] = seconds.get(name, 0.0) + taken
        found[name].append(Measured(kind, value / area - 1, False, 0.0))
