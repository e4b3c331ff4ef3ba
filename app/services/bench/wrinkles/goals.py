"""What angles from intensity must reach, each with what was found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from app.services.bench.radiometry.goals import MISSED, Goal
from app.services.bench.results import ResultTable, Value

NAME = "wrinkles_goals"
NOTE = "With --quick there are too few leaves to judge by."
Row = Mapping[str, Value]


def judge_goals(tables: Mapping[str, Sequence[Row]]) -> list[Goal]:
    """The goals of all tables, by their names."""
    return [
        *_judge_known(tables["wrinkles_known"]),
        *_judge_species(tables["wrinkles_species"]),
        *_judge_separation(tables["wrinkles_separation"]),
    ]


def _judge_known(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        if row["kind"] != "all" or row["points"] == "full hits":
            continue
        group = f"(a) {row['scene']}"
        yield Goal(group, "within 5°, of valid points", float(row["right"]), low=0.95)
        yield Goal(group, "valid, of points at 15° to 60°", float(row["valid_15_to_60"]), low=0.8)


def _judge_species(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        if row["omega_found_deg"] == "all":
            found = float(row["covered"])
            yield Goal(f"(b) {row['scene']}", "held by the 68 % interval", found, 0.63, 0.73)


def _judge_separation(rows: Sequence[Row]) -> Iterator[Goal]:
    for row in rows:
        found = float(row["auc_flat"])
        yield Goal(f"(c) {row['scene']}", "AUC, wrinkled against flat", found, low=0.95)


def tabulate_goals(goals: Sequence[Goal], quick: bool) -> ResultTable:
    """Goals as a table; a quick run has too few leaves to say that one is missed."""
    rows = [dict(goal.as_row()) for goal in goals]
    for row in rows:
        if quick and row["verdict"] == MISSED:
            row["verdict"] = "too few leaves"
    return ResultTable(NAME, "What must be reached", rows, NOTE)
