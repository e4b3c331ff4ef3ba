"""What a calibration must reach, each with what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from app.services.bench.results import ResultTable, Value

NAME = "radiometry_goals"
INVERSE = 1e-9
LEAST_COVERAGE, POOLED = 0.90, (0.93, 0.97)
BUDGET = (0.9, 1.1)
EQUATIONS = 1e-9
"""DN."""
NOTE = (
    "Of several figures of a kind, the one farthest from its goal; of means over reflectances, all "
    "together. With few seeds they are loose."
)

MISSED = "NOT REACHED"

Row = Mapping[str, Value]


@dataclass(frozen=True, slots=True)
class Goal:
    """A figure, and the interval in which it must lie."""

    group: str
    what: str
    found: float
    low: float = -np.inf
    high: float = np.inf

    @property
    def verdict(self) -> str:
        """Whether it is reached; a figure that is no number is not."""
        return "reached" if self.low <= self.found <= self.high else MISSED

    def as_row(self) -> Row:
        """A row of the table."""
        return {
            "group": self.group,
            "goal": self.what,
            "limit": self._tell_limit(),
            "found": float(f"{self.found:.4g}"),
            "verdict": self.verdict,
        }

    def _tell_limit(self) -> str:
        if np.isinf(self.low):
            return f"≤ {self.high:g}"
        return f"≥ {self.low:g}" if np.isinf(self.high) else f"{self.low:g} to {self.high:g}"


def judge_inverses(rows: Sequence[Row]) -> list[Goal]:
    """Speed and error of each inverse."""
    goals = []
    for row in (row for row in rows if row["way"] == "ours"):
        name, speed = str(row["inverse"]), float(row["million_per_s"])
        goals.append(
            Goal(name, "million points per second", speed, low=float(row["goal_million_per_s"]))
        )
    worst = max(float(row["largest_error"]) for row in rows if row["way"] == "ours")
    return [*goals, Goal("all inverses", "largest relative error", worst, high=INVERSE)]


def judge_hancock(coverage: Sequence[Row], reflectance: Sequence[Row]) -> list[Goal]:
    """Coverage of the joint fit's intervals, and its budget on independent targets."""
    goals = []
    for noise, rows in groupby(coverage[: -_count_pooled(coverage)], lambda row: row["noise"]):
        least = min(float(row["joint_coverage"]) for row in rows)
        goals.append(
            Goal(f"Hancock, {noise}", "least coverage of a parameter", least, LEAST_COVERAGE)
        )
    for row in coverage[-_count_pooled(coverage) :]:
        share = float(row["joint_coverage"])
        goals.append(Goal(f"Hancock, {row['noise']}", "pooled coverage", share, *POOLED))
    for row in reflectance:
        group = f"Hancock, {row['wavelength_nm']} nm, {row['noise']}"
        goals.append(Goal(group, "RMSE over the budget", float(row["ratio"]), *BUDGET))
    return goals


def _count_pooled(coverage: Sequence[Row]) -> int:
    return sum(row["parameter"] == "all" for row in coverage)


def judge_balduzzi(scatter: Sequence[Row], amplifier: Sequence[Row]) -> list[Goal]:
    """RMSE of the corrected DN by material, and the two equations."""
    ratio = _farthest([float(row["equation_7_ratio"]) for row in scatter])
    apart = float(amplifier[0]["equations_differ_dn"])
    return [
        Goal("Balduzzi", "RMSE over that of Table 2", ratio, *BUDGET),
        Goal("Balduzzi", "equations 6 and 7 without scatter, DN apart", apart, high=EQUATIONS),
    ]


def judge_junttila(rows: Sequence[Row]) -> list[Goal]:
    """The budget of each amplifier."""
    return [
        Goal(str(row["instrument"]), "RMSE over the budget", float(row["ratio"]), *BUDGET)
        for row in rows
    ]


def judge_budget(rows: Sequence[Row]) -> list[Goal]:
    """Predicted against observed errors on simulated scans.

    The worst reflectance for points. Means share the error of their calibration, so that the
    ratio of n seeds is unsure by 1 / √(2 n): their reflectances are taken together.
    """
    goals = []
    for key, group in groupby(rows, lambda row: (row["instrument"], row["power_from"])):
        found = list(group)
        points, means = (
            [float(row["ratio"]) for row in found if row["of"] == of] for of in ("point", "mean")
        )
        name, together = f"{key[0]}, power: {key[1]}", float(np.sqrt(np.mean(np.square(means))))
        goals.append(Goal(name, "observed over predicted, points", _farthest(points), *BUDGET))
        goals.append(Goal(name, "observed over predicted, means", together, *BUDGET))
    return goals


def _farthest(ratios: Sequence[float]) -> float:
    """The ratio that is farthest from 1."""
    return max(ratios, key=lambda ratio: abs(np.log(ratio)))


def tabulate_goals(goals: Sequence[Goal], quick: bool = False) -> ResultTable:
    """Goals as a table; a quick run has too few seeds to say that one is missed."""
    rows = [dict(goal.as_row()) for goal in goals]
    for row in rows:
        if quick and row["verdict"] == MISSED:
            row["verdict"] = "too few seeds"
    return ResultTable(NAME, "What must be reached", rows, NOTE)
