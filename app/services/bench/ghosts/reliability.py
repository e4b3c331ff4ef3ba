"""Whether the confidence of corrections keeps its word: said, against what came true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.services.bench.ghosts.measures import SIGMAS
from app.services.bench.ghosts.truth import Scene
from app.services.bench.results import ResultTable, Value

BORDERS = (0.0, 0.2, 0.5, 0.8, 0.85, 0.9, 0.95, 1.0)
NOTE = (
    "Ghosts by the confidence of their correction, all scenes of a kind together. said: mean "
    "confidence of the class; right: of its points, those that lie within 2 σ of the "
    "energy-weighted range of the dominant surface when put back, and no farther from it than "
    "before. Points that are no ghosts by the truth count as they fall. exact: the same of points "
    "whose true range is told free of noise; the truth of the other simulator's leaves holds the "
    "noise of the point itself. The program puts back from 0.8 on."
)


@dataclass(frozen=True, slots=True, eq=False)
class Reliability:
    """Ghosts of a scene in classes of confidence, (classes,) each.

    Attributes
    ----------
    count, right : numbers of points
    exact, exact_right : numbers of those whose truth is free of noise
    said : sum of confidences
    """

    count: Ints
    right: Ints
    exact: Ints
    exact_right: Ints
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
    exact = scene.exact[called]

    def count(some: Bools) -> Ints:
        return np.bincount(place[some], minlength=classes)

    total: Floats = np.bincount(place, said, minlength=classes).astype(np.float64)
    everyone = np.ones(len(called), bool)
    return Reliability(count(everyone), count(right), count(exact), count(exact & right), total)


def tabulate_reliability(judged: Sequence[tuple[str, Reliability]]) -> ResultTable:
    """Confidence against truth by kind of scene."""
    rows: list[dict[str, Value]] = []
    for kind in dict.fromkeys(name for name, _ in judged):
        some = [one for name, one in judged if name == kind]
        count, right, exact, exact_right, said = (
            sum(getattr(one, part) for one in some)
            for part in ("count", "right", "exact", "exact_right", "said")
        )
        for place, (low, high) in enumerate(pairwise(BORDERS)):
            if count[place]:
                rows.append({
                    "scenes": kind, "confidence": f"{low:g} to {high:g}",
                    "points": int(count[place]), "said_percent": _percent(said, count, place),
                    "right_percent": _percent(right, count, place),
                    "exact_points": int(exact[place]),
                    "exact_right_percent": _percent(exact_right, exact, place),
                })  # fmt: skip
    return ResultTable("ghosts_reliability", "Confidence against truth", rows, NOTE)


def _percent(part: Floats | Ints, whole: Ints, place: int) -> float:
    return round(100.0 * float(part[place] / whole[place]), 1) if whole[place] else float("nan")
