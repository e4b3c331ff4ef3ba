"""What must be reached, each with what was found, scene by scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from app.services.bench.ghosts.compare import Outcome
from app.services.bench.ghosts.rivals import SOR_FAST
from app.services.bench.radiometry.goals import Goal
from app.services.bench.results import ResultTable

F1 = {"phase shift": 0.95, "crown": 0.95, "pulsed, close": 0.90}
AIM = {"phase shift": 0.98, "crown": 0.98}
LEAST_SHARE, RECALL = 0.005, 0.80
FULL, CORRECTED, WITHIN, WORSE = 0.005, 0.5, 0.8, 0.02
SPEED, SPEED_AIM = 4.0, 10.0
TIMED = 100_000
"""Points from which a time tells more than how long a call takes."""
NOTE = (
    "One default setting everywhere, seeds from 100 on, which were not used in development. "
    "Speed: seconds of statistical outlier removal with 8 neighbours over ours, all after reading; "
    "on the quickest k-d tree, and on the one that SciPy makes unless asked. With --quick scans "
    "are too coarse to judge by."
)


def judge_all(outcomes: Sequence[Outcome]) -> list[Goal]:
    """The goals of all scenes."""
    return [
        goal
        for outcome in outcomes
        for judge in (_judge_calls, _judge_corrections, _judge_speed)
        for goal in judge(outcome)
    ]


def _judge_calls(outcome: Outcome) -> Iterator[Goal]:
    facts, calls = outcome.facts, outcome.ours.usual
    if facts.group in F1 and facts.ghosts >= LEAST_SHARE:
        aim = f" (aim {AIM[facts.group]:g})" if facts.group in AIM else ""
        yield Goal(facts.title, f"F1{aim}", calls.f1, low=F1[facts.group])
    if facts.group == "pulsed, apart":
        yield Goal(facts.title, "ghosts found", calls.recall, low=RECALL)
    what = "full hits of one leaf called ghosts"
    yield Goal(facts.title, what, calls.full_called, high=FULL)


def _judge_corrections(outcome: Outcome) -> Iterator[Goal]:
    facts, found = outcome.facts, outcome.corrections
    if np.isnan(found.share):  # no ghosts at large leaves
        return
    yield Goal(facts.title, "ghosts of large leaves corrected", found.share, low=CORRECTED)
    yield Goal(facts.title, "corrected points within 2 σ", found.within, low=WITHIN)
    yield Goal(facts.title, "corrected points farther than before", found.worse, high=WORSE)


def _judge_speed(outcome: Outcome) -> Iterator[Goal]:
    if outcome.facts.points < TIMED:
        return
    for name, words in zip(SOR_FAST, ("outlier removal", "SciPy's usual tree"), strict=True):
        peer = outcome.find(name)
        if peer is not None:
            times = peer.seconds / outcome.ours.seconds
            what = f"times as fast as {words} (aim {SPEED_AIM:g})"
            yield Goal(outcome.facts.title, what, times, low=SPEED)


def tabulate_goals(goals: Sequence[Goal]) -> ResultTable:
    """Goals as a table."""
    return ResultTable("ghosts_goals", "What must be reached", [g.as_row() for g in goals], NOTE)
