"""Whether the confidence of corrections keeps its word: said, against what came true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from app.core.arrays import Floats, Ints
from app.services.bench.ghosts.measures import SIGMAS
from app.services.bench.ghosts.truth import Scene
from app.services.bench.results import ResultTable, Value

BORDERS = (0.0, 0.2, 0.5, 0.8, 0.85, 0.9, 0.95, 1.0)
NOTE = (
    "Ghosts by the confidence of their correction, all scenes of a kind together. said: mean "
    "confidence of the class; right: of its points, those that lie within 2 σ of the "
    "energy-weighted range of the dominant surface when put back, and no farther from it than "
    "before. Points that are no ghosts by the truth count as they fall. The program puts back "
    "from 0.8 on."
)


@dataclass(frozen=True, slots=True, eq=False)
class Reliability:
    """Ghosts of a scene in classes of confidence, (classes,) each.

    Attributes
    ----------
    count, right : numbers of points
    said : sum of their confidences
    """

    count: Ints
    right: Ints
    said: Floats


def judge_confidence(scene: Scene, confidence: Floats, ranges: Floats) -> Reliability:
    """Count what came true.

    Parameters
    ----------
    scene : Scene
    confidence : (n,)
        NaN for points that are not called ghosts.
    ranges : (n,) metres
        Where they would be put.
    """
    called = np.flatnonzero(np.isfinite(confidence))
    said, classes = confidence[called], len(BORDERS) - 1
    place = np.clip(np.searchsorted(BORDERS, said, side="right") - 1, 0, classes - 1)
    after = np.abs(ranges[called] - scene.main[called])
    before = np.abs(scene.own[called] - scene.main[called])
    right = (after <= SIGMAS * scene.sigma[called]) & (after <= before)
    total: Floats = np.bincount(place, said, minlength=classes).astype(np.float64)
    return Reliability(
        np.bincount(place, minlength=classes), np.bincount(place[right], minlength=classes), total
    )


def tabulate_reliability(judged: Sequence[tuple[str, Reliability]]) -> ResultTable:
    """Confidence against truth by kind of scene."""
    rows: list[dict[str, Value]] = []
    for kind in dict.fromkeys(name for name, _ in judged):
        some = [one for name, one in judged if name == kind]
        count, right, said = (
            sum(getattr(one, part) for one in some) for part in ("count", "right", "said")
        )
        for place, (low, high) in enumerate(pairwise(BORDERS)):
            if count[place]:
                rows.append({
                    "scenes": kind, "confidence": f"{low:g} to {high:g}",
                    "points": int(count[place]),
                    "said_percent": round(100.0 * float(said[place] / count[place]), 1),
                    "right_percent": round(100.0 * float(right[place] / count[place]), 1),
                })  # fmt: skip
    return ResultTable("ghosts_reliability", "Confidence against truth", rows, NOTE)
