"""What must be reached, each with what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from app.core.units import to_mm
from app.services.bench.incidence.bound import LIMITS, Against
from app.services.bench.incidence.coverage import GOAL, TOLERANCE
from app.services.bench.incidence.rivals import OURS
from app.services.bench.incidence.scenes import CLEAN
from app.services.bench.results import ResultTable, Value

Row = Mapping[str, Value]
FASTER, MEDIAN, P90 = "times_faster", "median_ratio", "p90_ratio"
CLEAN_LIMITS = {FASTER: 25.0, MEDIAN: 0.5, P90: 0.6}
HARD_LIMITS = {FASTER: 15.0, MEDIAN: 0.75, P90: 0.8}
WORDS = {
    FASTER: "times faster than Open3D",
    MEDIAN: "median error / Open3D's",
    P90: "90 % error / Open3D's",
}
BEST = {
    "median_ratio_to_best": "median error / Open3D's best over radii",
    "p90_ratio_to_best": "90 % error / Open3D's best over radii",
}
SAME_GRID, SAME_VOXELS = 12.0, 5.0
EQUAL = 1e-6
"""Degrees."""
LEAVES, MEMORY = 0.02, 60.0
NOTE = (
    "Ours: the adaptive window, radius as given, against Open3D's radius search at the same radius "
    "in the same run. not measured: without --peers, or Open3D is missing."
)


@dataclass(frozen=True, slots=True)
class Goal:
    """A figure, and the limit on one side of it."""

    scene: str
    noise: str
    what: str
    found: float
    limit: float
    at_least: bool = False

    @property
    def verdict(self) -> str:
        """Whether it is reached; unknown where there is no figure."""
        if np.isnan(self.found):
            return "not measured"
        met = self.found >= self.limit if self.at_least else self.found <= self.limit
        return "reached" if met else "NOT REACHED"

    def as_row(self) -> Row:
        """A row of the table."""
        return {
            "scene": self.scene,
            "noise": self.noise,
            "goal": self.what,
            "limit": f"{'≥' if self.at_least else '≤'} {self.limit:g}",
            "found": float(f"{self.found:.4g}"),
            "verdict": self.verdict,
        }


def name_noise(row: Row) -> str:
    """Kind and σ of a row."""
    sigma = float(row["sigma_mm"])
    return str(row["noise"]) if np.isnan(sigma) else f"{row['noise']}, {sigma:g} mm"


def judge_rivals(rows: Sequence[Row], radius: float) -> list[Goal]:
    """Goals of the main table, load by load."""
    goals: list[Goal] = []
    at = float(f"{to_mm(radius):.4g}")
    ours = [row for row in rows if row["program"] == OURS and row["radius_mm"] == at]
    for (scene, _), load in groupby(ours, lambda row: (row["scene"], name_noise(row))):
        methods = {str(row["method"]): row for row in load}
        goals += _judge_adaptive(str(scene), methods["adaptive"])
        goals += _judge_ball(methods)
    return goals


def _judge_adaptive(scene: str, row: Row) -> list[Goal]:
    limits, noise = CLEAN_LIMITS if scene == CLEAN else HARD_LIMITS, name_noise(row)
    goals = [
        Goal(scene, noise, WORDS[name], float(row[name]), limit, name == FASTER)
        for name, limit in limits.items()
    ]
    best = [Goal(scene, noise, text, float(row[name]), 1.0) for name, text in BEST.items()]
    one_radius = np.isfinite(float(row[FASTER])) and np.isnan(best[0].found)
    return goals if scene == CLEAN or one_radius else goals + best


def _judge_ball(methods: Mapping[str, Row]) -> list[Goal]:
    grid, voxels = methods["ball, grid"], methods["ball, voxels"]
    scene, noise = str(grid["scene"]), name_noise(grid)
    return [
        Goal(scene, noise, f"{WORDS[FASTER]}: {name}", float(row[FASTER]), limit, True)
        for name, row, limit in (
            ("same estimator on the grid", grid, SAME_GRID),
            ("same estimator without grid", voxels, SAME_VOXELS),
        )
    ]


def judge_coverage(rows: Sequence[Row]) -> list[Goal]:
    """Coverage on flat and bent leaves, white noise, away from the pole: all their points."""
    return [
        Goal(
            str(row["scene"]), name_noise(row),
            f"share within 1 σ less {GOAL:g}, {row['leaves']} leaves",
            abs(float(row["within 1 σ"]) - GOAL), TOLERANCE,
        )
        for row in rows
        if row["noise"] == "white"
        and row["leaves"] in ("flat", "bent")
        and row["where"] == "away from the pole"
        and row["points"] == "all"
    ]  # fmt: skip


def judge_bound(found: Sequence[Against]) -> list[Goal]:
    """Rms errors on planes over the Cramér–Rao bound."""
    return [
        Goal(
            "planes", f"white, {to_mm(against.noise.sigma):g} mm",
            f"rms error / bound, {against.estimator}", against.whole, LIMITS[against.estimator],
        )
        for against in found
    ]  # fmt: skip


def tabulate_goals(goals: Sequence[Goal]) -> ResultTable:
    """Goals as a table."""
    rows = [goal.as_row() for goal in goals]
    return ResultTable("incidence_goals", "What must be reached", rows, NOTE)
