"""Our scans of the other simulator's kind of scene beside its own, measure by measure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.core.arrays import Floats
from app.core.progress import QUIET, Progress
from app.services.bench.results import ResultTable, Value
from app.services.bench.simulate.distributions import summarise
from app.services.bench.simulate.marks import read_marks, scan_marks
from app.services.bench.simulate.other_scene import SCENES, Name

CLOSE = 0.05
"""Relative difference within which two simulators agree, whatever the spread of scenes."""
SPREAD = 3.0
"""σ of scenes drawn alike within which they agree too."""
WIDE = 0.25
"""Relative spread from which scenes drawn alike tell nothing about a measure."""
SEEDS = 6
NOTE = (
    "ours: mean and sd over scenes drawn alike. Agrees: within 5 %, or within 3 sd of one scene "
    "about the mean of the others. Too spread: that is more than 25 %."
)


def compare_with_other(folder: Path, seeds: int = SEEDS, progress: Progress = QUIET) -> ResultTable:
    """The table of both scenes.

    Raises
    ------
    BadInput
        The other simulator's files cannot be read.
    """
    rows: list[dict[str, Value]] = []
    for place, name in enumerate(SCENES):
        part = progress.part(place / len(SCENES), (place + 1) / len(SCENES))
        rows += _compare_scene(folder, name, seeds, part)
    title = "Ghosts, borders and intensity beside another simulator's"
    return ResultTable("simulate_other", title, rows, NOTE)


def _compare_scene(
    folder: Path, name: Name, seeds: int, progress: Progress
) -> list[dict[str, Value]]:
    marks = read_marks(folder, name)
    theirs, ranges = summarise(marks), marks.ranges_of_leaves()
    ours = []
    for seed in range(seeds):
        progress.report(seed / seeds, f"Scanning scenes like {name}")
        ours.append(summarise(scan_marks(name, ranges, seed)))
    return [
        compare_measure(name, key, theirs[key], np.array([scene[key] for scene in ours]))
        for key in theirs
    ]


def compare_measure(scene: str, measure: str, theirs: float, ours: Floats) -> dict[str, Value]:
    """One row: their value, our mean and spread, and whether they agree."""
    known = ours[np.isfinite(ours)]
    if not np.isfinite(theirs) or len(known) < 2:
        mean, sd, verdict = np.nan, np.nan, "too few points"
    else:
        mean, sd = float(known.mean()), float(known.std(ddof=1))
        verdict = judge(abs(mean - theirs), sd * np.sqrt(1 + 1 / len(known)), abs(theirs))
    return {
        "scene": scene,
        "measure": measure,
        "theirs": theirs,
        "ours": mean,
        "sd": sd,
        "difference": mean / theirs - 1 if theirs else np.nan,
        "verdict": verdict,
    }


def judge(away: float, sd: float, theirs: float) -> str:
    """Whether a difference is small, or no larger than scenes drawn alike differ."""
    if away <= CLOSE * theirs:
        return "agrees"
    if SPREAD * sd > WIDE * theirs:
        return "too spread"
    return "agrees" if away <= SPREAD * sd else "DIFFERS"
