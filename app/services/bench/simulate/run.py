"""``leafscope bench simulate``: all tables and the picture of the virtual scanner's bench."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.checks import tabulate
from app.services.bench.picture import draw_panels
from app.services.bench.results import Bench, ResultTable, list_targets
from app.services.bench.simulate.against_other import SEEDS, compare_with_other
from app.services.bench.simulate.costs import draw_costs, measure_costs, warm_up
from app.services.bench.simulate.validation import validate

NAME = "simulate"
QUICK_SEEDS = 2


def bench_simulate(
    quick: bool = False, truth: Path | None = None, progress: Progress = QUIET
) -> Bench:
    """Check the virtual scanner, time it, and compare it with another simulator's scans.

    Parameters
    ----------
    quick : bool
        Fewer beams, angles, leaves and seeds.
    truth : Path, optional
        Folder with the other simulator's scans; no such table without it.
    progress : Progress

    Raises
    ------
    BadInput
        The other simulator's files cannot be read.
    Cancelled
    """
    compiling = warm_up()
    tables: list[ResultTable] = []
    if truth is not None:
        seeds = QUICK_SEEDS if quick else SEEDS
        tables.append(compare_with_other(truth, seeds, progress.part(0.0, 0.4)))
    checks = validate(quick, progress.part(0.4, 0.6))
    costs = measure_costs(compiling, quick, progress.part(0.6, 1.0))
    tables = [tabulate("simulate_checks", "Is the virtual scanner right?", checks), costs, *tables]
    return Bench(NAME, tuple(tables), {"simulate_costs": partial(draw_panels, draw_costs(costs))})


def refuse_bench_simulate(out: Path, truth: Path | None, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    names = ["simulate_checks", "simulate_costs", *(["simulate_other"] if truth else [])]
    refuse_targets(
        list_targets(out, NAME, names, ["simulate_costs"]), overwrite, folder_follows=True
    )
