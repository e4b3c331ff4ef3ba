"""The validation table of the virtual scanner."""

from __future__ import annotations

from collections.abc import Callable

from app.core.progress import QUIET, Progress
from app.services.bench.checks import Check
from app.services.bench.simulate.edge import check_edge
from app.services.bench.simulate.energy import check_energy
from app.services.bench.simulate.footprint import check_footprint
from app.services.bench.simulate.ghost_ranges import check_ghosts
from app.services.bench.simulate.hierarchy import check_hierarchy
from app.services.bench.simulate.noise import check_noise
from app.services.bench.simulate.plane import check_plane
from app.services.bench.simulate.presets import check_presets
from app.services.bench.simulate.shapes import check_shapes

CHECKS: dict[str, Callable[[bool], list[Check]]] = {
    "energy": check_energy,
    "plane": check_plane,
    "footprint": check_footprint,
    "ghosts": check_ghosts,
    "edge": check_edge,
    "noise": check_noise,
    "presets": check_presets,
    "leaf shapes": check_shapes,
    "hierarchy": check_hierarchy,
}


def validate(quick: bool = False, progress: Progress = QUIET) -> list[Check]:
    """Run all checks; `quick` takes fewer beams and angles."""
    found: list[Check] = []
    for place, (name, check) in enumerate(CHECKS.items()):
        progress.report(place / len(CHECKS), f"Checking {name}")
        found += check(quick)
    return found
