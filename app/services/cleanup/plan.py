"""An answer proposed for every ghost of a scan, with its evidence; nothing is changed yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.errors import WrongUse
from app.core.ghosts import SURE, Reasons, explain_points
from app.core.progress import QUIET, Progress
from app.model.ghost_fields import find_corrections, judged_score, shape_of_beam
from app.model.ghost_image import ghost_image_of
from app.model.project import Project
from app.model.state import ScanState
from app.services.cleanup.answers import Answer, Uncertain, is_answer
from app.services.cleanup.evidence import (
    DENSITY_METHOD,
    GRID_METHOD,
    LeafNames,
    light_for_words,
    say_reason,
)


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """The ghosts of a scan and what is proposed for each.

    Attributes
    ----------
    scan : str
    ghosts : (g,) numbers of the points
    score : (g,) 0 to 1
    shift : (g,) metres
        Along the beam to the surface that owns most of it; NaN where there is none.
    confidence : (g,) 0 to 1
    leaf : (g,) int
        Place of the leaf in `names`: its own, else that of the nearest surface; -1 without.
    proposal : (g,) int8
        Of `Answer`.
    reasons : Reasons or None
        None without rows and columns.
    names : LeafNames
    method : str
        How the score was found.
    threshold, sure : float
    uncertain : {'delete', 'mark'}
    """

    scan: str
    ghosts: Ints
    score: Floats
    shift: Floats
    confidence: Floats
    leaf: Ints
    proposal: AnyArray
    reasons: Reasons | None
    names: LeafNames
    method: str
    threshold: float
    sure: float
    uncertain: Uncertain

    def __len__(self) -> int:
        return len(self.ghosts)

    @property
    def correctable(self) -> Bools:
        """Ghosts that have a surface to go to."""
        return np.isfinite(self.shift)

    def answered(self, marks: AnyArray) -> Bools:
        """Ghosts that the user has answered, by the marks of all points."""
        return is_answer(marks[self.ghosts])

    def answers(self, marks: AnyArray, proposals: bool = True) -> AnyArray:
        """What becomes of each ghost, (g,) int8: the user's word, else the proposal (or 0).

        A ghost that is to be corrected and has no surface stays marked.
        """
        found = marks[self.ghosts]
        open_ = ~is_answer(found)
        found[open_] = self.proposal[open_] if proposals else 0
        found[(found == Answer.CORRECT) & ~self.correctable] = Answer.LEAVE
        return found

    def explain(self, place: int) -> str:
        """Why a ghost is one, by its place in `ghosts`."""
        score = f"score {self.score[place]:.2f}"
        if self.reasons is None:
            return f"{score}, {self.method}"
        return f"{score}: {say_reason(self.reasons, place, self.names)}"


def plan_cleanup(
    project: Project, scan: str, sure: float = SURE, uncertain: Uncertain | None = "delete",
    progress: Progress = QUIET,
) -> Plan:  # fmt: skip
    """Propose an answer for every ghost: correct where that is sure, else delete or leave.

    What the user keeps though the score speaks against it is part of the plan, so that he can
    change his mind.

    Parameters
    ----------
    sure : float
        Confidence from which a ghost is corrected, 0 to 1.
    uncertain : {'delete', 'mark'} or None
        What becomes of the others. None: deleted where the score comes from the scan grid,
        marked where it is the weaker one.

    Raises
    ------
    WrongUse, MissingScanner, Cancelled
    """
    if not 0.0 <= sure <= 1.0:
        raise WrongUse(f"A confidence lies in 0 to 1, not at {sure:g}.")
    score = project.field(scan, "ghost_score", None, progress.part(0.0, 0.6))
    state = project.state.scan(scan)
    threshold = state.parameters.ghost_threshold
    called = (score >= threshold) | (state.marks > 0)
    ghosts = np.flatnonzero(called & state.alive)
    judged = judged_score(state, score)
    names = LeafNames.gather(project.state.leaves_of(scan), len(score))
    reasons, method = _explain(state, ghosts, judged, progress.part(0.6, 0.8))
    shift, confidence = find_corrections(state, ghosts, judged, progress.part(0.8, 1.0))
    sure_enough = np.isfinite(shift) & (confidence >= sure)
    if uncertain is None:
        uncertain = "mark" if reasons is None else "delete"
    other = Answer.DELETE if uncertain == "delete" else Answer.LEAVE
    return Plan(
        scan,
        ghosts,
        score[ghosts],
        shift,
        confidence,
        _find_leaves(names, ghosts, reasons),
        np.where(sure_enough, Answer.CORRECT, other).astype(np.int8),
        reasons,
        names,
        method,
        threshold,
        sure,
        uncertain,
    )


def _explain(
    state: ScanState, ghosts: Ints, judged: Floats, progress: Progress
) -> tuple[Reasons | None, str]:
    image = ghost_image_of(state.scan, progress)
    if image is None:
        return None, DENSITY_METHOD
    # What is asked of a ghost is why it looks like one, also where the user keeps it.
    told = judged.copy()
    told[ghosts] = 1.0
    found = explain_points(
        image,
        ghosts,
        told,
        threshold=state.parameters.ghost_threshold,
        beam=shape_of_beam(state),
        light=light_for_words(state),
        progress=progress,
    )
    return found, GRID_METHOD


def _find_leaves(names: LeafNames, ghosts: Ints, reasons: Reasons | None) -> Ints:
    leaf: Ints = names.of[ghosts].astype(np.int64)
    if reasons is not None:
        member = reasons.member[:, 0]
        nearest = np.where(member >= 0, names.of[member], -1)
        leaf = np.where(leaf < 0, nearest, leaf)
    return leaf
