"""How many points a threshold would call ghosts, without asking the document again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats

BINS = 100


@dataclass(frozen=True, slots=True, eq=False)
class GhostCounts:
    """Scores of the living points of a scan, sorted for quick questions.

    Attributes
    ----------
    scores : (n,) array
        Sorted scores of points that the user has not judged.
    marked, kept : int
        Points judged by hand: ghosts whatever the score says, and no ghosts.
    unknown : int
        Points without a score and without a judgement.
    histogram : (100,) array
        Points per hundredth of the score, all living points with a score.
    """

    scores: Floats
    marked: int
    kept: int
    unknown: int
    histogram: AnyArray

    @property
    def total(self) -> int:
        """Living points."""
        return len(self.scores) + self.marked + self.kept + self.unknown

    def count(self, threshold: float) -> int:
        """Points that count as ghosts at this threshold: the rule of the field ``ghost``."""
        above = len(self.scores) - int(np.searchsorted(self.scores, threshold, side="left"))
        return self.marked + above


def count_ghosts(score: Floats, marks: AnyArray, alive: Bools) -> GhostCounts:
    """Sort the scores of a scan; arrays of all its points."""
    score, marks = score[alive], marks[alive]
    known = np.isfinite(score)
    open_ = marks == 0
    edges = np.linspace(0.0, 1.0, BINS + 1)
    return GhostCounts(
        scores=np.sort(score[known & open_]),
        marked=int(np.count_nonzero(marks > 0)),
        kept=int(np.count_nonzero(marks < 0)),
        unknown=int(np.count_nonzero(~known & open_)),
        histogram=np.histogram(score[known], edges)[0],
    )
