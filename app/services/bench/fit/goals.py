"""What fits must reach, each with what was found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from app.services.bench.fit.coverage import PAPER, SHOWN
from app.services.bench.fit.speed import MOST_MS
from app.services.bench.radiometry.goals import Goal
from app.services.bench.results import ResultTable, Value

NOTE = "With --quick there are too few fits and seeds to judge by."
Row = Mapping[str, Value]


def judge_all(tables: Mapping[str, Sequence[Row]]) -> list[Goal]:
    """The goals of all tables, by their names."""
    return [
        *_judge_batch(tables["fit_batch"]),
        *_judge_single(tables["fit_single"]),
        *_judge_printed(tables["fit_printed"]),
        *_judge_coverage(tables["fit_coverage"]),
        *_judge_rest(tables["fit_models"], tables["fit_stability"]),
    ]


def _judge_batch(rows: Sequence[Row]) -> Iterator[Goal]:
    most = max(rows, key=lambda row: int(row["fits"]))
    name = f"{most['fits']} fits"
    yield Goal(name, "times faster than the loop", float(most["times_faster"]), low=50.0)
    above = sum(int(row["above_best"]) for row in rows)
    judged = sum(int(row["judged"]) for row in rows)
    yield Goal(f"{judged} fits", "worse than the best of 20 starts", float(above), high=0.0)


def _judge_single(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        if row["points"] == 10_000:
            found = float(row["of_curve_fit"])
            yield Goal("10 000 points", "time over that of curve_fit", found, high=1.0)
        if row["points"] == 100_000:
            yield Goal("100 000 points", "ms of a fit", float(row["ours_ms"]), high=MOST_MS)


def _judge_printed(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        found = float(row["verdict"] == "reached")
        yield Goal(f"{row['count']} printed pairs, {row['leaves']}", "found again", found, low=1.0)


def _judge_coverage(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        if row["interval"] == SHOWN and row["noise_percent"] == round(100 * PAPER, 6):
            group = f"95 % intervals, {row['noise']} noise of {row['noise_percent']:g} %"
            if row["parameter"] == "all":
                yield Goal(group, "coverage, pooled", float(row["covered"]), 0.93, 0.97)
            else:
                what = f"coverage of {row['parameter']}"
                yield Goal(group, f"least {what} on a leaf", float(row["least"]), 0.91, 0.99)
                yield Goal(group, f"greatest {what} on a leaf", float(row["most"]), 0.91, 0.99)


def _judge_rest(models: Sequence[Row], stability: Sequence[Row]) -> Iterator[Goal]:
    worst = max(float(row["error"]) for row in models)
    yield Goal("all models", "largest error of exact curves, of the usual range", worst, high=1e-6)
    better = sum(int(row["better"]) for row in models)
    yield Goal("all models", "second opinions that are better", float(better), high=0.0)
    wrong = sum(row["verdict"] == "WRONG" for row in stability)
    yield Goal("data at the edge", "neither right nor refused", float(wrong), high=0.0)


def tabulate_goals(goals: Sequence[Goal]) -> ResultTable:
    """Goals as a table."""
    return ResultTable("fit_goals", "What must be reached", [g.as_row() for g in goals], NOTE)
