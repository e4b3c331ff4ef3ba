"""``leafscope bench fit``: time, misses, coverage, recovery and stability, in one run."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.fit.coverage import measure_coverage, recover_printed
from app.services.bench.fit.goals import judge_all, tabulate_goals
from app.services.bench.fit.models import recover_models
from app.services.bench.fit.pictures import draw_costs
from app.services.bench.fit.speed import compare_batch, compare_single
from app.services.bench.fit.stability import check_stability
from app.services.bench.fit.trade import measure_trade
from app.services.bench.results import Bench, list_targets

NAME = "fit"
TABLES = (
    "fit_goals", "fit_batch", "fit_single", "fit_trade", "fit_printed", "fit_coverage",
    "fit_models", "fit_stability",
)  # fmt: skip


def bench_fit(quick: bool = False, progress: Progress = QUIET) -> Bench:
    """Fits of angular models against SciPy's curve_fit and against the truth.

    Parameters
    ----------
    quick : bool
        Few fits and seeds: to see that it works, not to judge by.
    progress : Progress

    Raises
    ------
    Cancelled
    """
    # Times first: what follows keeps the machine warm, and its caches full.
    single = compare_single(quick, progress.part(0.0, 0.05))
    trade = measure_trade(quick, progress.part(0.05, 0.15))
    batch = compare_batch(quick, progress.part(0.15, 0.7))
    printed = recover_printed()
    coverage = measure_coverage(quick, progress.part(0.7, 0.9))
    models = recover_models(quick, progress.part(0.9, 0.95))
    stability = check_stability(quick, progress.part(0.95, 1.0))
    found = (batch, single, trade, printed, coverage, models, stability)
    goals = tabulate_goals(judge_all({table.name: table.rows for table in found}))
    return Bench(NAME, (goals, *found), {NAME: partial(draw_costs, trade.rows)})


def refuse_bench_fit(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    refuse_targets(list_targets(out, NAME, list(TABLES), [NAME]), overwrite, folder_follows=True)
