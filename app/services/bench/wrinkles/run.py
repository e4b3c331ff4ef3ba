"""``leafscope bench wrinkles``: what angles from intensity claim, held against the truth."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.results import Bench, list_targets
from app.services.bench.wrinkles.cases import (
    compare_known,
    compare_levelled,
    cover_species,
    judge_all,
)
from app.services.bench.wrinkles.goals import judge_goals, tabulate_goals
from app.services.bench.wrinkles.pictures import draw_trade
from app.services.bench.wrinkles.scenes import (
    FIRST_SEED,
    OTHERS,
    TrueLeaf,
    list_plans,
    read_other,
    scan_plan,
)
from app.services.bench.wrinkles.separation import compare_indices, tell_wrinkled
from app.services.bench.wrinkles.trade import REPEATS, measure_trade

NAME = "wrinkles"
FEW = 6
"""Of so many leaves, a quick run looks at one."""
TABLES = (
    "wrinkles_goals", "wrinkles_known", "wrinkles_species", "wrinkles_levelled",
    "wrinkles_separation", "wrinkles_index", "wrinkles_trade",
)  # fmt: skip


def bench_wrinkles(
    quick: bool = False, truth: Path | None = None, progress: Progress = QUIET
) -> Bench:
    """Angles from intensity in the three cases, on simulated leaves.

    Parameters
    ----------
    quick : bool
        One coarse scan: to see that it works, not to judge by.
    truth : Path or None
        Folder with another simulator's scans, to take in too.
    progress : Progress

    Raises
    ------
    BadInput
        The other simulator's files cannot be read.
    Cancelled
    """
    scenes = list(_make_scenes(quick, truth, progress.part(0.0, 0.4)))
    scenes = [scene[:: FEW if quick else 1] for scene in scenes]
    leaves = [leaf for scene in scenes for leaf in scene]
    trade = measure_trade(scenes[0], 1 if quick else REPEATS, progress.part(0.4, 0.6))
    judged = judge_all(leaves, FIRST_SEED, progress.part(0.6, 0.9))
    known, levelled = compare_known(judged), compare_levelled(judged)
    progress.report(0.9, "Coverage")
    species = cover_species(judged)
    separation, index = tell_wrinkled(judged), compare_indices(judged)
    found = (known, species, levelled, separation, index, trade)
    goals = judge_goals({table.name: table.rows for table in found})
    tables = (tabulate_goals(goals, quick), *found)
    return Bench(NAME, tables, {NAME: partial(draw_trade, trade.rows)})


def _make_scenes(quick: bool, truth: Path | None, progress: Progress) -> list[list[TrueLeaf]]:
    plans = list_plans(quick)
    total = len(plans) + (len(OTHERS) if truth else 0)
    found = [
        scan_plan(plan, progress.part(place / total, (place + 1) / total))
        for place, plan in enumerate(plans)
    ]
    for place, name in enumerate(OTHERS if truth else (), len(plans)):
        progress.report(place / total, f"Reading {name}")
        if truth is not None:
            found.append(read_other(truth, name))
    return found


def refuse_bench_wrinkles(out: Path, truth: Path | None, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    sources = [] if truth is None else list(truth.glob("*"))
    refuse_targets(
        list_targets(out, NAME, list(TABLES), [NAME]), overwrite, sources, folder_follows=True
    )
