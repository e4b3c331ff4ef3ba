"""Why a single point is a ghost, or none: asked by hovering over it, so it has to be quick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.errors import WrongUse
from app.core.ghosts import GhostImage, Reason, explain_points
from app.core.progress import QUIET, Progress
from app.model.ghost_fields import judged_score, shape_of_beam
from app.model.ghost_image import ghost_image_of
from app.model.leaf import Leaf
from app.model.state import ScanState
from app.services.cleanup.evidence import (
    DENSITY_METHOD,
    GRID_METHOD,
    LeafNames,
    light_for_words,
    say_reason,
)


@dataclass(frozen=True, slots=True)
class Explanation:
    """What is known of one point.

    Attributes
    ----------
    ghost : bool
        Whether it counts as one now.
    score : float
    reason : Reason or None
        None without rows and columns.
    sentence : str
    method : str
        How the score was found.
    """

    ghost: bool
    score: float
    reason: Reason | None
    sentence: str
    method: str


class Explainer:
    """Explains points of one scan as it is; what it needs for that is laid out only once.

    Parameters
    ----------
    state : ScanState
    leaves : sequence of Leaf
    score : (n,)
        Ghost score of all points.
    """

    def __init__(self, state: ScanState, leaves: Sequence[Leaf], score: Floats) -> None:
        self._state, self._leaves, self._score = state, leaves, score
        self._ground: _Ground | None = None

    def explain(self, row: int, progress: Progress = QUIET) -> Explanation:
        """Say why a point is a ghost or not; may run in any one thread.

        Raises
        ------
        WrongUse
            There is no such point.
        MissingScanner, Cancelled
        """
        if not 0 <= row < len(self._score):
            raise WrongUse(f"There is no point {row} in {self._state.scan.name}.")
        if self._ground is None:
            self._ground = _prepare(self._state, self._leaves, self._score, progress)
        ground, score = self._ground, float(self._score[row])
        ghost = bool(ground.called[row])
        head = _say_verdict(self._state, row, ghost, score)
        method = DENSITY_METHOD if ground.image is None else GRID_METHOD
        if not np.isfinite(score):
            return Explanation(ghost, score, None, head, method)
        if ground.image is None:
            return Explanation(ghost, score, None, f"{head} {method}", method)
        found = explain_points(
            ground.image,
            np.array([row]),
            ground.judged,
            threshold=self._state.parameters.ghost_threshold,
            beam=shape_of_beam(self._state),
            light=ground.light,
            progress=progress,
        )
        said = say_reason(found, 0, ground.names, ghost)
        reason = Reason(int(found.reason[0]))
        return Explanation(ghost, score, reason, f"{head} {said}", GRID_METHOD)


@dataclass(frozen=True, slots=True, eq=False)
class _Ground:
    """What all points of a scan are explained from."""

    names: LeafNames
    image: GhostImage | None
    light: Floats | None
    called: Bools
    judged: Floats


def _prepare(
    state: ScanState, leaves: Sequence[Leaf], score: Floats, progress: Progress
) -> _Ground:
    called = (score >= state.parameters.ghost_threshold) & (state.marks >= 0) | (state.marks > 0)
    return _Ground(
        LeafNames.gather(leaves, len(score)),
        ghost_image_of(state.scan, progress),
        light_for_words(state),
        called,
        judged_score(state, score),
    )


def _say_verdict(state: ScanState, row: int, ghost: bool, score: float) -> str:
    mark = int(state.marks[row])
    if not np.isfinite(score):
        return "No score: the point has no range, or the beams lie too far apart."
    by = f"{score:.2f}"
    if mark < 0:
        return f"Kept by hand (score {by}):"
    if mark > 0:
        return f"Ghost by hand (score {by}):"
    return f"{'Ghost' if ghost else 'No ghost'} (score {by}):"
