"""What a beam costs: against sub-rays, leaves, resolution and threads, and the plain loop."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from app.core.chunks import count_processors
from app.core.progress import QUIET, Progress
from app.services.bench.picture import Curve, Panel
from app.services.bench.results import ResultTable, Value
from app.services.bench.simulate.rig import silent
from app.services.bench.timing import can_choose_threads, time_in_turns, use_threads
from app.simulate.beam import BeamGrid, Bundle, grid_of_field
from app.simulate.instrument import Instrument
from app.simulate.parts.scatter import ScatterPart
from app.simulate.parts.wall import WallPart
from app.simulate.scanner import trace_beams
from app.simulate.scene_building import build_scene
from app.simulate.scene_file import Field, SceneFile, get_scene
from app.simulate.surfaces import Scene

FIELD = ((-8.5, 8.5), (-6.5, 6.5))
USUAL = 250
"""Leaves of the scene that the issue of the virtual scanner names."""
RAYS = (1, 7, 19, 37, 61, 91)
LEAVES = (1, 10, 100, 250, 1_000, 10_000)
STEPS = (0.2, 0.1, 0.05, 0.025)
PLAIN_BEAMS = 100_000_000
"""Beams × leaves that the plain loop is given: a second, as preparing 10 000 leaves takes."""
REPEATS = 5
Run = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Load:
    """Something to be timed: a scene, the beams sent into it, and what varies."""

    curve: str
    value: float
    scene: Scene
    grid: BeamGrid
    instrument: Instrument
    threads: int = 0
    plain_grid: BeamGrid | None = None

    @property
    def beams(self) -> int:
        """How many beams a run sends."""
        return count_beams(self.grid)

    def run(self, grid: BeamGrid | None = None, hierarchy: bool = True) -> None:
        """Trace all beams of the load's grid, or of another."""
        with use_threads(self.threads or count_processors()):
            beams = self.grid if grid is None else grid
            trace_beams(self.scene, beams, self.instrument, (0, 0, 1.6), hierarchy=hierarchy)


def count_beams(grid: BeamGrid) -> int:
    """Beams of a grid."""
    return grid.rows * grid.columns


def measure_costs(compiling: float, quick: bool = False, progress: Progress = QUIET) -> ResultTable:
    """The cost curves; `quick` leaves out what takes long.

    `compiling` are the seconds that `warm_up` took, before anything else ran.
    """
    loads = [*_vary_subrays(quick), *_vary_leaves(quick), *_vary_steps(quick), *_vary_threads()]
    taken = time_in_turns(
        {f"{k} {name}": run for k, load in enumerate(loads) for name, run in _rivals(load).items()},
        1 if quick else REPEATS,
        progress,
    )
    medians = {name: timing.median for name, timing in taken.items()}
    rows = [
        _tell(load, {name: medians[f"{k} {name}"] for name in _rivals(load)})
        for k, load in enumerate(loads)
    ]
    note = (
        "Medians of runs that take turns. Beams per second: with preparing the scene; µs per "
        f"beam: without. Compiling the kernels, or loading them, took {compiling:.1f} s before. "
        f"Two-colour phase shift, 37 sub-rays, {USUAL} leaves before a wall, "
        f"{count_processors()} threads, unless the curve says other."
    )
    return ResultTable("simulate_costs", "What a beam costs", rows, note)


def warm_up() -> float:
    """Run every kernel once; seconds that it took."""
    start = time.perf_counter()
    load = Load("", 0, scatter(3), grid_of_field(1.0, *FIELD), silent())
    load.run()
    load.run(hierarchy=False)
    return time.perf_counter() - start


def scatter(leaves: int) -> Scene:
    """Leaves in the usual field, flat, bent and wrinkled in turn, before a wall."""
    azimuth, elevation = (-8.0, 8.0), (-6.0, 6.0)
    part = ScatterPart(count=leaves, azimuth_deg=azimuth, elevation_deg=elevation)
    field = Field(azimuth_deg=FIELD[0], elevation_deg=FIELD[1])
    file = SceneFile(name=f"{leaves} leaves", part=(part, WallPart(range=5.5)), field=field)
    return build_scene(file, silent().wavelengths_nm)


def _vary_subrays(quick: bool) -> list[Load]:
    scene, grid = scatter(USUAL), grid_of_field(0.1 if quick else 0.04, *FIELD)
    return [Load("sub-rays", n, scene, grid, silent(bundle=Bundle(rays=n))) for n in RAYS]


def _vary_leaves(quick: bool) -> list[Load]:
    counts = LEAVES[:4] if quick else LEAVES
    beams = 10_000 if quick else 100_000
    many = _field_of(beams)
    loads = []
    for count in counts:
        few = _field_of(min(PLAIN_BEAMS // count, beams))
        loads.append(Load("leaves", count, scatter(count), many, silent(), plain_grid=few))
    if not quick:
        loads.append(_load_crown())
    return loads


def _field_of(beams: int) -> BeamGrid:
    """The usual field with about so many beams."""
    (left, right), (low, high) = FIELD
    return grid_of_field(((right - left) * (high - low) / beams) ** 0.5, *FIELD)


def _load_crown() -> Load:
    file = get_scene("crown")
    scene = build_scene(file, silent().wavelengths_nm)
    grid = grid_of_field(0.15, (-12.0, 12.0), (-6.0, 20.0))
    return Load("crown", len(scene.leaves), scene, grid, silent())


def _vary_steps(quick: bool) -> list[Load]:
    scene = scatter(USUAL)
    steps = STEPS[:2] if quick else STEPS
    return [Load("step, °", step, scene, grid_of_field(step, *FIELD), silent()) for step in steps]


def _vary_threads() -> list[Load]:
    if not can_choose_threads():
        return []
    most = count_processors()
    counts = sorted({1, 2, most // 2, most} - {0})
    load = Load("threads", 0, scatter(USUAL), grid_of_field(0.08, *FIELD), silent())
    return [replace(load, value=count, threads=count) for count in counts if count <= most]


def _rivals(load: Load) -> dict[str, Run]:
    """What is timed of a load; preparing is what a run of one beam takes."""
    one = replace(load.grid, rows=1, columns=1)
    rivals: dict[str, Run] = {"hierarchy": load.run, "preparing": partial(load.run, one)}
    if load.plain_grid is not None:
        rivals["plain"] = partial(load.run, load.plain_grid, hierarchy=False)
        rivals["preparing plain"] = partial(load.run, one, hierarchy=False)
    return rivals


def _tell(load: Load, taken: dict[str, float]) -> dict[str, Value]:
    """A row of the table; what is not preparing is shared out among the beams."""
    own = max(taken["hierarchy"] - taken["preparing"], 0.0) / load.beams
    plain = float("nan")
    if load.plain_grid is not None:
        beams = count_beams(load.plain_grid)
        plain = max(taken["plain"] - taken["preparing plain"], 0.0) / beams
    return {
        "curve": load.curve,
        "value": load.value,
        "beams": load.beams,
        "preparing, s": round(taken["preparing"], 4),
        "all, s": round(taken["hierarchy"], 4),
        "beams per second": round(load.beams / taken["hierarchy"]),
        "µs per beam": round(own * 1e6, 3),
        "plain loop, µs per beam": round(plain * 1e6, 3),
        "plain over hierarchy": round(plain / own, 2) if own > 0 else float("nan"),
    }


def draw_costs(table: ResultTable) -> tuple[Panel, ...]:
    """Time of a beam against leaves, both ways, and against sub-rays."""
    leaves = [row for row in table.rows if row["curve"] == "leaves"]
    rays = [row for row in table.rows if row["curve"] == "sub-rays"]
    counts, own, plain = (
        [float(row[name]) for row in leaves]
        for name in ("value", "µs per beam", "plain loop, µs per beam")
    )
    each = [[float(row[name]) for row in rays] for name in ("value", "µs per beam")]
    curves = (Curve("hierarchy", counts, own), Curve("all leaves", counts, plain, dashed=True))
    return (
        Panel("Time of a beam: leaves", "leaves", "µs per beam", curves, "log", "log"),
        Panel(
            "Time of a beam: sub-rays", "sub-rays", "µs per beam", (Curve("", each[0], each[1]),)
        ),
    )
