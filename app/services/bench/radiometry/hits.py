"""Full hits among points at edges: `hit_fraction` against a jump in range, with the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.neighbours.steps import Cells, as_cells
from app.core.progress import QUIET, Progress
from app.core.radiometry.partial_hits import FULL_HIT, hit_fraction
from app.model.scan import Grid
from app.services.bench.results import ResultTable, Value
from app.services.bench.timing import time_in_turns
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.virtual_scan import simulate

NAME = "radiometry_hits"
TRULY_FULL = 0.98
JUMP = 0.01
"""Metres."""
TURNS, QUICK_TURNS = 5, 1
SIDES = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0))
NOTE = (
    f"Full: at least {TRULY_FULL:.0%} of the beam on one surface, by the simulator's truth; ours: "
    f"hit_fraction of {FULL_HIT:g} or more. Precision: of the points taken as full, those that "
    "are; recall: of the full ones, those taken; partial kept: of the partial ones, those taken. "
    f"Jump: a point is partial where one of the eight around it is {100 * JUMP:g} cm farther or "
    "nearer; with holes: or is missing. Lacking: median part of the beam that is not on the "
    "surface, of partial hits that are kept."
)


@dataclass(frozen=True, slots=True)
class View:
    """A ready scene, an instrument and the step between beams, degrees."""

    scene: str
    instrument: str
    step_deg: float


VIEWS = (
    View("pear_row", "ls880", 0.06),
    View("panels", "x330", 0.03),
    View("scattered", "ls880", 0.03),
    View("scattered", "salca", 0.06),
)
QUICK_VIEWS = (View("scattered", "ls880", 0.12),)


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A scan with its truth: points, the cells of a grid, and the beam's share on its surface."""

    xyz: Floats
    cells: Cells
    scanner: Floats
    share: Floats
    tool: Instrument


def compare_hits(quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """All views, all ways.

    Raises
    ------
    Cancelled
    """
    views = QUICK_VIEWS if quick else VIEWS
    rows: list[dict[str, Value]] = []
    for place, view in enumerate(views):
        progress.report(place / len(views), f"Hits in {view.scene}")
        rows += _measure(view, quick)
    return ResultTable(NAME, "Which points are full hits", rows, NOTE)


def see(view: View) -> Seen:
    """Scan a scene."""
    tool = get_instrument(view.instrument)
    scan = simulate(view.scene, tool, step_deg=view.step_deg).scan
    share = scan.attributes["truth_hit_fraction"].astype(float)
    grid = cast(Grid, scan.grid)  # every simulated scan has one
    return Seen(scan.xyz, as_cells(grid), scan.scanner("full hits"), share, tool)


def _measure(view: View, quick: bool) -> list[dict[str, Value]]:
    seen = see(view)
    ways: dict[str, Callable[[], Bools]] = {
        "hit_fraction": lambda: find_full(seen),
        "jump": lambda: find_level(seen, holes=False),
        "jump with holes": lambda: find_level(seen, holes=True),
    }
    taken = {name: way() for name, way in ways.items()}
    timings = time_in_turns(ways, QUICK_TURNS if quick else TURNS)
    full = seen.share >= TRULY_FULL
    rows: list[dict[str, Value]] = []
    for name, kept in taken.items():
        wrong = kept & ~full
        rows.append(
            {
                "scene": view.scene,
                "instrument": view.instrument,
                "points": len(full),
                "partial_percent": _percent(~full),
                "way": name,
                "seconds": float(f"{timings[name].median:.3g}"),
                "precision_percent": _percent(full[kept]),
                "recall_percent": _percent(kept[full]),
                "partial_kept_percent": _percent(kept[~full]),
                "lacking_percent": _percent(1.0 - seen.share[wrong], np.median),
            }
        )
    return rows


def _percent(of: Floats | Bools, take: Callable[..., object] = np.mean) -> float:
    return float(f"{100 * float(take(of)):.4g}") if len(of) else float("nan")  # type: ignore[arg-type]


def find_full(seen: Seen) -> Bools:
    """Ours."""
    bundle = seen.tool.bundle
    share = hit_fraction(
        seen.xyz, seen.scanner, seen.cells, bundle.exit_diameter / 2, bundle.half_divergence
    )
    return np.asarray(share >= FULL_HIT)


def find_level(seen: Seen, holes: bool) -> Bools:
    """Points whose neighbours in the grid are all about as far away."""
    away = np.linalg.norm(seen.xyz - seen.scanner, axis=1)
    row, column = seen.cells.row.astype(np.int64) + 1, seen.cells.column.astype(np.int64) + 1
    image = np.full((seen.cells.rows + 2, seen.cells.columns + 2), np.nan)
    image[row, column] = away
    level = np.ones(len(away), bool)
    for up, left in SIDES:
        apart = np.abs(image[row + up, column + left] - away)
        level &= (apart <= JUMP) if holes else ~(apart > JUMP)
    return level
