"""What is counted: ghosts found, good points lost, and where corrected points went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.services.bench.ghosts.truth import Scene

SIGMAS = 2.0


@dataclass(frozen=True, slots=True)
class Calls:
    """How right it is to call some points ghosts; points that count for neither are left out.

    Attributes
    ----------
    f1, recall, precision : float
        NaN where the scene has no ghosts; precision also where nothing is called.
    full_called : float
        Share of the points wholly on one leaf that are called ghosts.
    good_called : float
        Share of all points on a surface that are.
    """

    f1: float
    recall: float
    precision: float
    full_called: float
    good_called: float


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Recall and precision at every setting of a score, from strict to loose; each (k,)."""

    setting: Floats
    recall: Floats
    precision: Floats
    f1: Floats

    @property
    def best(self) -> int:
        """Place of the largest F1; −1 where there is none to find."""
        return int(np.argmax(self.f1)) if np.any(self.f1 > 0.0) else -1


@dataclass(frozen=True, slots=True)
class Corrections:
    """Where corrected points went.

    Attributes
    ----------
    share : float
        Corrected ones of the ghosts whose dominant surface is a leaf with enough full hits.
    within : float
        Of all corrected points, those within 2 σ of their own range noise from the
        energy-weighted range of the dominant surface.
    worse : float
        Of them, those farther from it than before.
    exact : float
        Share of the corrected points for which that range is known free of noise.
    exact_within, exact_worse : float
        The same of those alone.
    count : int
        Corrected points.
    """

    share: float
    within: float
    worse: float
    exact: float
    exact_within: float
    exact_worse: float
    count: int


def judge_calls(scene: Scene, called: Bools, missing: Bools | None = None) -> Calls:
    """Judge which points are called ghosts.

    Parameters
    ----------
    scene : Scene
    called : (n,) bool
    missing : (n,) bool, optional
        Points that a method says nothing of: always counted as wrong.
    """
    silent = np.zeros(len(scene), bool) if missing is None else missing
    found = int(np.sum(called & ~silent & scene.ghost))
    total = int(scene.ghost.sum())
    lost = total - found
    accused = called | silent
    false = int(np.sum(accused & scene.good))
    return Calls(
        f1=_divide(2 * found, 2 * found + lost + false) if total else np.nan,
        recall=_divide(found, total),
        precision=_divide(found, found + false) if total else np.nan,
        full_called=_divide(int(np.sum(accused & scene.full)), int(scene.full.sum())),
        good_called=_divide(false, int(scene.good.sum())),
    )


def trace_curve(scene: Scene, score: Floats) -> Curve:
    """Recall, precision and F1 of `score` ≥ setting, at every value that the score takes.

    Ghosts without a score are never found; good points without one are always called.
    """
    judged = scene.ghost | scene.good
    ghost, value = scene.ghost[judged], score[judged]
    silent = np.isnan(value)
    total, wrong = int(ghost.sum()), int(np.sum(silent & ~ghost))
    ghost, value = ghost[~silent], value[~silent]
    order = np.argsort(-value, kind="stable")
    value, ghost = value[order], ghost[order]
    last = (
        np.flatnonzero(np.append(value[1:] != value[:-1], True)) if len(value) else np.empty(0, int)
    )
    found = np.cumsum(ghost)[last]
    false = last + 1 - found + wrong
    with np.errstate(invalid="ignore"):
        recall, precision = found / max(total, 1), found / (found + false)
        f1 = 2.0 * found / (found + false + total)
    return Curve(value[last], recall, precision, f1)


def judge_corrections(scene: Scene, corrected: Bools, ranges: Floats) -> Corrections:
    """Judge where corrected points were put.

    Parameters
    ----------
    scene : Scene
    corrected : (n,) bool
    ranges : (n,) metres
        Of the corrected points, along their beams; missing ones count as wrong.
    """
    asked = scene.ghost & scene.large
    after = np.abs(ranges - scene.main)[corrected]
    before = np.abs(scene.own - scene.main)[corrected]
    near = after <= SIGMAS * scene.sigma[corrected]
    # Written so that a missing range is worse.
    worse, exact = ~(after <= before), scene.exact[corrected]
    return Corrections(
        share=_divide(int(np.sum(corrected & asked)), int(asked.sum())),
        within=_mean(near),
        worse=_mean(worse),
        exact=_mean(exact),
        exact_within=_mean(near[exact]),
        exact_worse=_mean(worse[exact]),
        count=len(after),
    )


def _divide(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")


def _mean(flags: Bools) -> float:
    return float(flags.mean()) if len(flags) else float("nan")
