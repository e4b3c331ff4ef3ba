"""What areas and segmentations must reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from app.services.bench.area.leaves import OURS
from app.services.bench.radiometry.goals import Goal
from app.services.bench.results import ResultTable, Value

LIMITS = {"flat": (3.0, 8.0), "bent": (3.0, 8.0), "wrinkled": (5.0, 15.0)}
COVERED = (88.0, 98.0)
LEAST_F1 = 0.9
NOTE = "With --quick there are too few leaves to judge by."
Row = Mapping[str, Value]


def judge(areas: Sequence[Row], segments: Sequence[Row]) -> list[Goal]:
    """Goals of all leaves pooled, by kind and cleaning; and of each scan's segmentation."""
    goals = []
    for row in areas:
        if row["way"] != OURS or row["kind"] not in LIMITS or row["judged"] != "yes":
            continue
        group = f"{row['scans']}, {row['cleaned']}, {row['kind']}"
        median, ninety = LIMITS[str(row["kind"])]
        goals.append(Goal(group, "median error, %", float(row["median"]), -median, median))
        goals.append(Goal(group, "error of 90 %, %", float(row["p90"]), high=ninety))
    for row in areas:
        if row["way"] == OURS and row["kind"] == "all" and row["judged"] == "yes":
            group = f"{row['scans']}, {row['cleaned']}"
            goals.append(Goal(group, "intervals that hold, %", float(row["covered"]), *COVERED))
    for row in segments:
        goals.append(
            Goal(f"{row['scan']}, {row['ghosts']}", "F1 of leaves", float(row["f1"]), LEAST_F1)
        )
    return goals


def tabulate_goals(goals: Sequence[Goal]) -> ResultTable:
    """Goals as a table."""
    return ResultTable("area_goals", "What must be reached", [g.as_row() for g in goals], NOTE)
