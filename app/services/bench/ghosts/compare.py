"""Ours and all peers on one scene: what each finds, and how long it takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import perf_counter

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.progress import QUIET, Progress
from app.services.bench.ghosts import ours
from app.services.bench.ghosts.measures import (
    Calls,
    Corrections,
    Curve,
    judge_calls,
    judge_corrections,
    trace_curve,
)
from app.services.bench.ghosts.reliability import Reliability, judge_confidence
from app.services.bench.ghosts.rivals import SOR_FAST, Rival, list_rivals
from app.services.bench.ghosts.scenes import make_scene
from app.services.bench.ghosts.truth import Group, Scene
from app.services.bench.timing import time_in_turns

TURNS = 3
SHOWN = 300
"""Settings of a curve that are kept for the picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """What a method reaches on a scene.

    Attributes
    ----------
    family, variant : str
    usual, best : Calls
        At its usual setting, and at the one with the largest F1 on this very scene.
    usual_at, best_at : float
    curve : Curve
        Thinned.
    seconds : float
        Everything after reading.
    """

    family: str
    variant: str
    usual: Calls
    best: Calls
    usual_at: float
    best_at: float
    curve: Curve
    seconds: float

    @property
    def name(self) -> str:
        """Unlike any other."""
        return f"{self.family}, {self.variant}" if self.variant else self.family

    @property
    def is_ours(self) -> bool:
        """Not a peer."""
        return self.family == ours.NAME


@dataclass(frozen=True, slots=True)
class Facts:
    """What remains to be known of a scene; its points take too much memory to keep.

    Attributes
    ----------
    name, group : str
    seed : int
    title : str
    points : int
    ghosts, unsure, full : float
        Shares of the points.
    leaf_ghosts, of_large : int
        Ghosts whose dominant surface is a leaf, and one with enough full hits.
    """

    name: str
    group: Group
    seed: int
    title: str
    points: int
    ghosts: float
    unsure: float
    full: float
    leaf_ghosts: int
    of_large: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """All results on a scene, ours first; where our corrections went, and how sure they were."""

    facts: Facts
    results: tuple[Result, ...]
    corrections: Corrections
    reliability: Reliability

    @property
    def ours(self) -> Result:
        """Our own."""
        return self.results[0]

    @property
    def rivals(self) -> tuple[Result, ...]:
        """The peers'."""
        return self.results[1:]

    def find(self, name: str) -> Result | None:
        """The result of that name."""
        return next((result for result in self.results if result.name == name), None)


def warm_up() -> None:
    """Compile, or load, all kernels, so that no measured second holds it."""
    for name in ("dense leaves, coarse step", "pulsed, close"):
        scene = make_scene(name, 1, step_deg=0.12)
        ours.judge(scene.scan, scene.beam)


def compare(scene: Scene, peers: bool = True, progress: Progress = QUIET) -> tuple[Outcome, Bools]:
    """Run ours, and the peers, on a scene.

    Ours and statistical outlier removal take turns, and the middle time counts; the other peers
    run once. Also gives the points that we call ghosts, (n,).
    """
    begun = perf_counter()
    answer = ours.judge(scene.scan, scene.beam)
    spent = perf_counter() - begun
    usual = judge_calls(scene, answer.called, np.isnan(answer.score))
    found = [_judge(scene, (ours.NAME, "", np.nan), answer.score, spent, usual)]
    rivals = list_rivals() if peers else ()
    for place, rival in enumerate(rivals):
        progress.report(0.7 * place / len(rivals), f"{scene.title}: {rival.name}")
        begun = perf_counter()
        score = rival.score(scene.scan)
        spent = perf_counter() - begun
        about = (rival.family, rival.variant, rival.usual)
        found.append(_judge(scene, about, score, spent, judge_calls(scene, score >= rival.usual)))
    if peers:
        seconds = _take_turns(scene, rivals, progress.part(0.7, 1.0))
        found = [replace(one, seconds=seconds.get(one.name, one.seconds)) for one in found]
    corrections = judge_corrections(scene, answer.corrected, answer.ranges)
    reliability = judge_confidence(scene, answer.confidence, answer.ranges)
    return Outcome(gather_facts(scene), tuple(found), corrections, reliability), answer.called


def gather_facts(scene: Scene) -> Facts:
    """What remains to be known of a scene."""
    return Facts(
        scene.name, scene.group, scene.seed, scene.title, len(scene),
        ghosts=float(scene.ghost.mean()),
        unsure=float(np.mean(~(scene.ghost | scene.good))),
        full=float(scene.full.mean()),
        leaf_ghosts=int(np.sum(scene.ghost & (scene.leaf >= 0))),
        of_large=int(np.sum(scene.ghost & scene.large)),
    )  # fmt: skip


def _take_turns(scene: Scene, rivals: Sequence[Rival], progress: Progress) -> Mapping[str, float]:
    """Middle seconds of ours and of the quickest outlier removals, by name."""
    runs: dict[str, Callable[[], object]] = {ours.NAME: lambda: ours.judge(scene.scan, scene.beam)}
    for rival in rivals:
        if rival.name in SOR_FAST:
            runs[rival.name] = lambda rival=rival: rival.score(scene.scan)  # type: ignore[misc]
    timed = time_in_turns(runs, TURNS, progress)
    return {name: median(timing.seconds) for name, timing in timed.items()}


def _judge(
    scene: Scene, about: tuple[str, str, float], score: Floats, seconds: float, usual: Calls
) -> Result:
    curve = trace_curve(scene, score)
    best_at = float(curve.setting[curve.best]) if curve.best >= 0 else np.nan
    # Without ghosts no setting is best; comparing with NaN calls nothing.
    best = judge_calls(scene, score >= best_at, np.isnan(score))
    family, variant, usual_at = about
    return Result(family, variant, usual, best, usual_at, best_at, thin(curve), seconds)


def thin(curve: Curve) -> Curve:
    """The curve at `SHOWN` settings, evenly along it, the best among them."""
    length = np.cumsum(
        np.hypot(np.diff(curve.recall, prepend=0), np.diff(curve.precision, prepend=1))
    )
    if len(length) <= SHOWN:
        return curve
    kept = np.searchsorted(length, np.linspace(0.0, length[-1], SHOWN - 1))
    kept = np.unique(np.append(np.minimum(kept, len(length) - 1), curve.best))
    return Curve(*(part[kept] for part in (curve.setting, curve.recall, curve.precision, curve.f1)))
