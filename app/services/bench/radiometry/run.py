"""``leafscope bench radiometry``: every method, its simple alternative, and the error budget."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.radiometry import balduzzi, hancock, junttila
from app.services.bench.radiometry.budgets import prove_budget
from app.services.bench.radiometry.fits import compare_fits
from app.services.bench.radiometry.goals import (
    judge_balduzzi,
    judge_budget,
    judge_hancock,
    judge_inverses,
    judge_junttila,
    tabulate_goals,
)
from app.services.bench.radiometry.hits import compare_hits
from app.services.bench.radiometry.pictures import draw_costs
from app.services.bench.radiometry.range_methods import compare_ranges
from app.services.bench.radiometry.responses import measure_inverses
from app.services.bench.radiometry.waveforms import measure_waveforms
from app.services.bench.results import Bench, ResultTable, list_targets

NAME = "radiometry"
TABLES = (
    "radiometry_goals", "radiometry_inverses", "radiometry_ranges", "radiometry_fits",
    "radiometry_waveforms", "radiometry_hits", "radiometry_budget", "hancock_coverage",
    "hancock_reflectance", "hancock_singular", "hancock_forms", "balduzzi_scatter",
    "balduzzi_amplifier", "junttila",
)  # fmt: skip
QUICK_SEEDS = 4
"""Of the papers' data."""


def bench_radiometry(quick: bool = False, progress: Progress = QUIET) -> Bench:
    """Time and error of every step from number to reflectance, and of its simple alternative.

    Parameters
    ----------
    quick : bool
        Few points and seeds: to see that it works, not to judge by.
    progress : Progress

    Raises
    ------
    Cancelled
    """
    # Times first: what follows keeps the machine warm, and its caches full.
    costs = (
        measure_inverses(quick, progress.part(0.0, 0.06)),
        compare_ranges(quick, progress.part(0.06, 0.12)),
        compare_fits(quick, progress.part(0.12, 0.18)),
        measure_waveforms(quick, progress.part(0.18, 0.23)),
        compare_hits(quick, progress.part(0.23, 0.28)),
    )
    budget = prove_budget(quick, progress.part(0.28, 0.65))
    papers = tell_papers(quick, progress.part(0.65, 1.0))
    found = {table.name: table.rows for table in papers}
    goals = [
        *judge_inverses(costs[0].rows),
        *judge_hancock(found["hancock_coverage"], found["hancock_reflectance"]),
        *judge_balduzzi(found["balduzzi_scatter"], found["balduzzi_amplifier"]),
        *judge_junttila(found["junttila"]),
        *judge_budget(budget.rows),
    ]
    tables = (tabulate_goals(goals, quick), *costs, budget, *papers)
    return Bench(NAME, tables, {NAME: partial(draw_costs, costs)})


def tell_papers(quick: bool, progress: Progress = QUIET) -> tuple[ResultTable, ...]:
    """The calibrations of the papers on data with their numbers."""
    salca = hancock.run_trials(QUICK_SEEDS if quick else hancock.SEEDS, progress.part(0.0, 0.9))
    panels = balduzzi.run_trials(QUICK_SEEDS if quick else balduzzi.SEEDS, progress.part(0.9, 0.95))
    amplifiers = junttila.run_trials(
        QUICK_SEEDS if quick else junttila.SEEDS, progress.part(0.95, 1.0)
    )
    return (
        hancock.tabulate_coverage(salca),
        hancock.tabulate_reflectance(salca),
        hancock.tabulate_singular(),
        hancock.tabulate_forms(),
        balduzzi.tabulate_scatter(panels),
        balduzzi.tabulate_amplifier(panels),
        junttila.tabulate(amplifiers),
    )


def refuse_bench_radiometry(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    refuse_targets(list_targets(out, NAME, list(TABLES), [NAME]), overwrite, folder_follows=True)
