"""``leafscope bench incidence``: all tables and the picture, in one run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from app.core.errors import WrongUse
from app.core.incidence import RADIUS
from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.incidence import scenes
from app.services.bench.incidence.bound import measure_bound
from app.services.bench.incidence.coverage import measure_coverage, tabulate_coverage
from app.services.bench.incidence.goals import (
    EQUAL,
    LEAVES,
    MEMORY,
    Goal,
    judge_bound,
    judge_coverage,
    judge_rivals,
    name_noise,
    tabulate_goals,
)
from app.services.bench.incidence.leaves import measure_leaves
from app.services.bench.incidence.memory import measure_memory
from app.services.bench.incidence.peers import Peer, find_peers
from app.services.bench.incidence.pictures import draw_fronts
from app.services.bench.incidence.plan import Field, run_all, warm_up
from app.services.bench.incidence.reference import compare_with_tree
from app.services.bench.incidence.rivals import Load, Rival
from app.services.bench.incidence.scenes import FILTERED, GIVEN, STRONG, USUAL, Noise, Truth
from app.services.bench.incidence.table import tabulate, tell_kinds, tell_load
from app.services.bench.results import Bench, ResultTable, Value, list_targets

NAME = "incidence"
TABLES = ("incidence", "goals", "coverage", "bound", "kinds", "programs")
NOISES = (USUAL, STRONG, FILTERED)
Row = dict[str, Value]
Making = tuple[Callable[[], Truth], tuple[Noise, ...]]


def bench_incidence(
    peers: bool = False,
    radius: float = RADIUS,
    quick: bool = False,
    truth: Path | None = None,
    progress: Progress = QUIET,
) -> Bench:
    """Time and error of every way to find the angle of incidence, on scans with exact truth.

    Parameters
    ----------
    peers : bool
        Take the programs of others in, where they are installed.
    radius : float
        Metres, given to all.
    quick : bool
        Small scans, few radii, one turn: to see that it works, not to judge by.
    truth : Path, optional
        Folder with another simulator's scans.
    progress : Progress

    Raises
    ------
    BadInput
        The other simulator's files cannot be read.
    WrongUse
        The radius is not positive.
    Cancelled
    """
    if not 0.0 < radius < float("inf"):
        raise WrongUse(f"The radius must be positive, not {radius} m.")
    known = find_peers() if peers else ()
    field = Field(radius, known, quick)
    warm_up(field)
    found = _Findings(field)
    makings = list(_list_scenes(quick, truth))
    for place, (make, noises) in enumerate(makings):
        part = progress.part(0.9 * place / len(makings), 0.9 * (place + 1) / len(makings))
        found.take(make(), noises, part)
    progress.report(0.9, "The smallest errors possible")
    against, bounds = measure_bound(quick)
    progress.report(1.0)
    goals = [
        *judge_rivals(found.rows, radius), *found.goals, *([] if quick else [judge_leaves(radius)]),
        *judge_coverage(found.coverage), *judge_bound(against),
    ]  # fmt: skip
    kinds = ResultTable("incidence_kinds", "Errors by the shape of the leaf", found.kinds)
    tables = (
        tabulate(found.rows), tabulate_goals(goals), tabulate_coverage(found.coverage), bounds,
        kinds, tell_peers(known),
    )  # fmt: skip
    return Bench(NAME, tables, {NAME: partial(draw_fronts, found.rows, radius)})


def refuse_bench_incidence(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    names = [NAME if name == NAME else f"{NAME}_{name}" for name in TABLES]
    refuse_targets(list_targets(out, NAME, names, [NAME]), overwrite, folder_follows=True)


def _list_scenes(quick: bool, truth: Path | None) -> Iterator[Making]:
    """How each scene is made, and the noises that it gets; made when it is its turn."""
    yield partial(scenes.make_clean, quick), (USUAL,) if quick else NOISES
    step = scenes.QUICK_STEP if quick else scenes.OWN_STEP
    yield partial(scenes.make_hard, step, scenes.HARD), (USUAL,) if quick else NOISES
    if not quick:
        yield partial(scenes.make_hard, scenes.FINE_STEP, scenes.FINE), (USUAL,)
    if truth is not None:
        for name in scenes.OTHERS:
            yield partial(scenes.read_other, truth, name), (GIVEN,)


class _Findings:
    """Rows of all scenes so far."""

    def __init__(self, field: Field) -> None:
        self.field = field
        self.rows: list[Row] = []
        self.kinds: list[Row] = []
        self.coverage: list[Row] = []
        self.goals: list[Goal] = []

    def take(self, truth: Truth, noises: tuple[Noise, ...], progress: Progress) -> None:
        """Run everything on a scene."""
        for place, noise in enumerate(noises):
            part = progress.part(place / len(noises), (place + 1) / len(noises))
            load = Load(truth, noise, truth.add_noise(noise))
            rivals = run_all(load, self.field, part)
            self.rows += tell_load(rivals)
            self.kinds += tell_kinds(self._at_radius(rivals))
            if noise == USUAL:
                self.goals += self._measure_once(load)
        self.coverage += measure_coverage(truth, noises, self.field.radius)

    def _at_radius(self, rivals: list[Rival]) -> list[Rival]:
        return [rival for rival in rivals if rival.radius == self.field.radius]

    def _measure_once(self, load: Load) -> list[Goal]:
        """What one noise tells enough of: equal angles, the cost of leaves, memory."""
        truth, xyz, radius = load.truth, load.xyz, self.field.radius
        noise = name_noise(self.rows[-1])
        goals = []
        for grid, words in ((True, "on the grid"), (False, "without grid")):
            equal = compare_with_tree(truth, xyz, radius, grid)
            what = f"degrees from a k-d tree's angles, {words} ({equal.compared} points)"
            goals.append(Goal(truth.name, noise, what, equal.worst, EQUAL))
        memory = measure_memory(truth, xyz, radius)
        what = "bytes per cell beyond the points"
        return [*goals, Goal(truth.name, noise, what, memory, MEMORY)]


def judge_leaves(radius: float) -> Goal:
    """Ten leaves of a scan of 2 million points must cost no more than their share, about."""
    truth = scenes.make_whole()
    cost = measure_leaves(truth, truth.add_noise(USUAL), radius)
    what = f"seconds of 10 leaves / of all ({cost.share:.2%} of the points)"
    return Goal(truth.name, "white, 0.7 mm", what, cost.part, LEAVES)


def tell_peers(peers: tuple[Peer, ...]) -> ResultTable:
    """Which programs took part."""
    rows: list[Row] = [
        {"program": peer.program, "state": "took part" if peer.found else "missing"}
        for peer in peers
    ]
    asked = rows or [{"program": "others", "state": "not asked: give --peers"}]
    return ResultTable("incidence_programs", "Programs of others", asked)
