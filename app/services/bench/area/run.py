"""``leafscope bench area``: areas of leaves and their segmentation, against truth and peers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from app.core.arrays import AnyArray, Bools, Ints
from app.core.mesh import estimate_beam
from app.core.progress import QUIET, Progress
from app.core.segments import segment_leaves
from app.formats.atomic import refuse_targets
from app.services.bench.area.goals import judge, tabulate_goals
from app.services.bench.area.leaves import OURS, RIVALS, Found, measure_case
from app.services.bench.area.measures import Measured, match_segments, summarise
from app.services.bench.area.scenes import (
    KINDS,
    OTHERS,
    Case,
    find_ghosts,
    list_plans,
    make_case,
    read_other,
)
from app.services.bench.picture import Dots, Scatter, draw_scatters
from app.services.bench.results import Bench, ResultTable, Value, list_targets

NAME = "area"
TABLES = ("area_goals", "area_leaves", "area_segments", "area_costs")
TRUE, FOUND, UNKNOWN = "true leaves, true ghosts out", "found leaves and ghosts", "beam unknown"
OUR_SCANS, THEIRS = "ours", "other simulator"
NOTE = (
    "Leaves of 50 full hits or more with a mean angle below 60° of which 95 % are seen (of the "
    "other simulator: that we call whole). Percent of the true area; median signed, p90 and "
    "largest of the size. interval: mean half width. Seeds from 100 on; tuned on 1 to 20."
)
SEGMENT_NOTE = (
    "Leaves of 50 full hits or more; same: intersection over union above 0.5 of the visible "
    "points that are no ghosts by truth. Without the option --truth only our own scans."
)
Key = tuple[str, str]
Pool = dict[Key, Found]


def bench_area(quick: bool = False, truth: Path | None = None, progress: Progress = QUIET) -> Bench:
    """Areas and segments of simulated leaves.

    Parameters
    ----------
    quick : bool
        One small scan: to see that it works, not to judge by.
    truth : Path or None
        Folder with another simulator's scans.
    progress : Progress

    Raises
    ------
    BadInput, Cancelled
    """
    pool: Pool = {}
    segments: list[dict[str, Value]] = []
    seconds: dict[str, float] = {}
    total = len(list_plans(quick)) + (len(OTHERS) if truth is not None else 0)
    for place, (scans, case) in enumerate(_list_cases(quick, truth)):
        progress.report(place / total, case.name)
        segments += _run_case(scans, case, pool, seconds)
    areas = _tabulate(pool)
    table = ResultTable("area_leaves", "Areas of leaves", areas, NOTE)
    found = ResultTable("area_segments", "Leaves found", segments, SEGMENT_NOTE)
    costs = _tabulate_costs(pool, seconds)
    goals = tabulate_goals(judge(areas, segments))
    panels = [
        _draw(costs.rows, "median_error", "median error"),
        _draw(costs.rows, "error_of_90_percent", "error of 90 % of the leaves"),
    ]
    picture = partial(draw_scatters, panels)
    return Bench(NAME, (goals, table, found, costs), {NAME: picture})


def refuse_bench_area(out: Path, overwrite: bool) -> None:
    """Raise `BadInput` where the bench could not write its files; cheap."""
    refuse_targets(list_targets(out, NAME, list(TABLES), [NAME]), overwrite, folder_follows=True)


def _list_cases(quick: bool, truth: Path | None) -> Iterator[tuple[str, Case]]:
    for plan in list_plans(quick):
        yield OUR_SCANS, make_case(plan)
    for name in OTHERS if truth is not None else ():
        yield THEIRS, read_other(truth or Path(), name)


def _run_case(
    scans: str, case: Case, pool: Pool, seconds: dict[str, float]
) -> list[dict[str, Value]]:
    rows = []
    called = find_ghosts(case)
    for name, ghosts in ((TRUE, case.ghosts), (FOUND, called)):
        layout = case.layout
        label = segment_leaves(layout.xyz, layout.scanner, case.cells, ghosts=ghosts)
        match = match_segments(label, case.leaf, case.full, ~case.ghosts)
        rows.append({
            "scan": case.name, "ghosts": "by truth" if name == TRUE else "as found",
            "found": match.found, "missed": match.missed, "false": match.false,
            "f1": round(match.f1, 4),
        })  # fmt: skip
        if not case.leaves:
            continue
        if name == TRUE:
            members = _members(case.leaf, ~ghosts, range(len(case.leaves)))
            _add(pool, (scans, TRUE), measure_case(case, members, ghosts, case.beam, seconds))
            guessed = estimate_beam(case.layout, members.values(), ghosts)
            other = measure_case(case, members, ghosts, guessed, {}, told=False)
            _add(pool, (scans, UNKNOWN), {OURS: other[OURS]})
        else:
            of_segment = _members(label, ~ghosts, range(int(label.max(initial=-1)) + 1))
            own = {k: of_segment[s] for k, s in enumerate(match.segment.tolist()) if s >= 0}
            _add(pool, (scans, FOUND), measure_case(case, own, ghosts, case.beam, {}))
    return rows


def _members(label: AnyArray, kept: Bools, numbers: range) -> dict[int, Ints]:
    rows = np.flatnonzero((label >= 0) & kept)
    rows = rows[np.argsort(label[rows], kind="stable")]
    borders = np.searchsorted(label[rows], np.arange(len(numbers) + 1))
    return {k: np.sort(rows[borders[k] : borders[k + 1]]) for k in numbers}


def _add(pool: Pool, key: Key, found: Found) -> None:
    mine = pool.setdefault(key, {})
    for way, measured in found.items():
        mine.setdefault(way, []).extend(measured)


def _tabulate(pool: Pool) -> list[dict[str, Value]]:
    rows: list[dict[str, Value]] = []
    for (scans, cleaned), by_way in pool.items():
        for way, measured in by_way.items():
            for kind in (*KINDS, "all"):
                chosen = [m for m in measured if kind in (m.kind, "all")]
                judged = way == OURS and cleaned != UNKNOWN and bool(chosen)
                rows.append({
                    "scans": scans, "cleaned": cleaned, "way": way, "kind": kind,
                    "judged": "yes" if judged else "", **summarise(chosen),
                })  # fmt: skip
    return rows


def _tabulate_costs(pool: Pool, seconds: dict[str, float]) -> ResultTable:
    """Milliseconds of a leaf, and the 90 % error, by way, on our scans cleaned by truth."""
    by_way = pool.get((OUR_SCANS, TRUE), {})
    rows: list[dict[str, Value]] = []
    for way in (OURS, *RIVALS):
        measured: list[Measured] = by_way.get(way, [])
        told = summarise(measured)
        taken = 1e3 * seconds.get(way, np.nan) / max(len(measured), 1)
        rows.append(
            {
                "way": way,
                "ms_per_leaf": round(taken, 3),
                "median_error": abs(told["median"]),
                "error_of_90_percent": told["p90"],
            }
        )
    return ResultTable("area_costs", "Time against error", rows, "Our scans, true ghosts out.")


def _draw(rows: Sequence[Mapping[str, Value]], column: str, name: str) -> Scatter:
    dots = [
        Dots(
            str(row["way"]), [float(row["ms_per_leaf"])], [float(row[column])], [str(row["way"])],
            [row["way"] == OURS], row["way"] != OURS,
        )
        for row in rows
    ]  # fmt: skip
    return Scatter(f"Area of a leaf: {name}", "ms per leaf", f"{name}, %", dots)
