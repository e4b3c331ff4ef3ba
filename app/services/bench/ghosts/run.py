"""``leafscope bench ghosts``: ghosts found and put back, against the truth and against peers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.ghosts.compare import Outcome, compare, warm_up
from app.services.bench.ghosts.goals import judge_all, tabulate_goals
from app.services.bench.ghosts.map import MAPPED, Map, draw_map, make_map
from app.services.bench.ghosts.pictures import draw_costs, draw_curves
from app.services.bench.ghosts.plans import PLANS
from app.services.bench.ghosts.reliability import tabulate_reliability
from app.services.bench.ghosts.scenes import OTHERS, make_scene, read_other
from app.services.bench.ghosts.tables import tabulate_calls, tabulate_corrections, tabulate_scenes
from app.services.bench.ghosts.truth import Scene
from app.services.bench.results import Bench, list_targets

NAME = "ghosts"
TABLES = (
    "ghosts_goals",
    "ghosts_calls",
    "ghosts_corrections",
    "ghosts_reliability",
    "ghosts_scenes",
)
PICTURES = ("ghosts", "ghosts_curves", "ghosts_map")
SEEDS = (101, 102)
"""The peers take part in the first."""
Making = tuple[Callable[[], Scene], bool]


def bench_ghosts(
    quick: bool = False, truth: Path | None = None, progress: Progress = QUIET
) -> Bench:
    """Our way with ghost points, and those of others, on scans whose ghosts are known.

    Parameters
    ----------
    quick : bool
        Coarse scans of one seed: to see that it works, not to judge by.
    truth : Path, optional
        Folder with another simulator's scans.
    progress : Progress

    Raises
    ------
    BadInput
        The other simulator's files cannot be read.
    Cancelled
    """
    makings = _list_scenes(quick, truth)
    warm_up()
    outcomes: list[Outcome] = []
    mapped: Map | None = None
    for place, (make, peers) in enumerate(makings):
        part = progress.part(place / len(makings), (place + 1) / len(makings))
        part.report(0.0, "Scanning")
        scene = make()
        outcome, called = compare(scene, peers, part)
        outcomes.append(outcome)
        if mapped is None and scene.name == MAPPED:
            mapped = make_map(scene, called)
    tables = (
        tabulate_goals(judge_all(outcomes)),
        tabulate_calls(outcomes),
        tabulate_corrections(outcomes),
        tabulate_reliability([(_kind(one), one.reliability) for one in outcomes]),
        tabulate_scenes(outcomes),
    )
    rich = [one for one in outcomes if one.rivals and one.facts.ghosts > 0.0]
    pictures = {"ghosts": partial(draw_costs, rich), "ghosts_curves": partial(draw_curves, rich)}
    if mapped is not None:
        pictures["ghosts_map"] = partial(draw_map, mapped)
    return Bench(NAME, tables, pictures)


def _kind(outcome: Outcome) -> str:
    """Scenes whose corrections are counted together; those of the other simulator stand alone."""
    facts = outcome.facts
    return facts.title if facts.seed < 0 else facts.group


def refuse_bench_ghosts(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    targets = list_targets(out, NAME, list(TABLES), list(PICTURES))
    refuse_targets(targets, overwrite, folder_follows=True)


def _list_scenes(quick: bool, truth: Path | None) -> list[Making]:
    """How each scene is made when it is its turn, and whether peers take part."""
    makings: list[Making] = [
        (partial(make_scene, plan.name, seed, quick), seed == SEEDS[0])
        for plan in PLANS
        if not (quick and plan.slow)
        for seed in (SEEDS[:1] if quick else SEEDS)
    ]
    if truth is not None:
        makings += [(partial(read_other, truth, name), True) for name in OTHERS]
    return makings
