"""``leafscope bench stability``: each case, all ways; a table for each kind of result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.core.progress import QUIET, Progress
from app.formats.atomic import refuse_targets
from app.services.bench.results import Bench, ResultTable, Value, list_targets
from app.services.bench.stability import ghosts, inversions, meshes, reflectances
from app.services.bench.stability.changes import list_changes
from app.services.bench.stability.spoilt import list_spoilt
from app.services.bench.stability.ways import WAYS, Case

NAME = "stability"
SIDE, QUICK_SIDE = 96, 48
"""Cells along each side of a scan."""
NOTE = (
    "Largest deviation of any angle, degrees: of a changed scan from the same one unchanged, or "
    "from the true angle where there is no noise. inf: an angle is missing, or one too many. "
    "moved: far coordinates against the same rounded ones, brought back exactly; rounded: against "
    "those before rounding, 99 % of the points (a neighbour may fall on either side of a rim). "
    "Poles and grids that do not follow the beams are left to balls by all."
)


def list_cases() -> list[Case]:
    """All cases of angles, in the order of the table."""
    return [*list_changes(), *list_spoilt()]


def bench_stability(quick: bool = False, progress: Progress = QUIET) -> Bench:
    """Run all cases.

    Parameters
    ----------
    quick : bool
        Smaller scans.
    progress : Progress

    Raises
    ------
    Cancelled
    """
    rows: list[dict[str, Value]] = []
    cases = list_cases()
    for place, case in enumerate(cases):
        progress.report(0.9 * place / len(cases), case.name)
        rows.append(tell_case(case, QUICK_SIDE if quick else SIDE))
    table = ResultTable(NAME, "What must not change an angle of incidence", rows, NOTE)
    progress.report(0.9, "Reflectances")
    told = reflectances.check_reflectances(quick)
    progress.report(0.97, "Angles from intensity")
    others = (inversions.check_inversions(), ghosts.check_ghosts(), meshes.check_meshes())
    return Bench(NAME, (table, told, *others), {})


def tell_case(case: Case, side: int) -> dict[str, Value]:
    """One row: the deviation of each way, and whether all are within the limit."""
    outcomes = {way.name: case.run(way, side) for way in WAYS}
    failed = [name for name, outcome in outcomes.items() if not outcome.worst <= case.limit]
    return {
        "group": case.group,
        "case": case.name,
        "angles": max(outcome.compared for outcome in outcomes.values()),
        "limit": case.limit,
        **{name: float(f"{outcome.worst:.3g}") for name, outcome in outcomes.items()},
        "verdict": _judge(failed),
    }


def _judge(failed: Sequence[str]) -> str:
    return "FAILS: " + ", ".join(failed) if failed else "holds"


def refuse_bench_stability(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    parts = (reflectances, inversions, ghosts, meshes)
    names = [NAME, *(part.NAME for part in parts)]
    refuse_targets(list_targets(out, NAME, names, []), overwrite, folder_follows=True)
