"""All answers of a clean-up as one step of the history."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from app.core.arrays import AnyArray, Floats
from app.core.units import group_digits
from app.model.operations import (
    AnyOperation,
    Coordinates,
    MarkGhosts,
    MovePoints,
    Numbers,
    PutLeaf,
    SetDeleted,
    Several,
)
from app.model.points import PointSet
from app.model.selection import Explicit
from app.model.state import State
from app.services.cleanup.answers import WORDS, Answer
from app.services.cleanup.plan import Plan


def make_step(state: State, plan: Plan, answers: AnyArray) -> Several:
    """The one step that does what is answered; undone as one.

    Corrected points move along their beams, join the leaf onto which they come back, and count
    as kept: they are where the beam met the surface.

    Parameters
    ----------
    state : State
        As it was when the plan was made, marks apart.
    plan : Plan
    answers : (g,) int8
        Of `Answer`; 0 leaves a ghost alone.
    """
    kept, left, deleted, corrected = (
        PointSet(plan.ghosts[answers == answer])
        for answer in (Answer.KEEP, Answer.LEAVE, Answer.DELETE, Answer.CORRECT)
    )
    steps: list[AnyOperation] = []
    if len(corrected):
        to = Coordinates(move(state, plan, answers))
        sure = Numbers(plan.confidence[answers == Answer.CORRECT])
        steps.append(MovePoints(plan.scan, corrected, to, sure))
    if len(deleted):
        steps.append(SetDeleted(plan.scan, deleted))
    if len(kept) + len(left) + len(corrected):
        steps.append(MarkGhosts(plan.scan, ghosts=left, kept=kept | corrected))
    steps += _join_leaves(state, plan, answers)
    return Several(describe_answers(answers), tuple(steps))


def move(state: State, plan: Plan, answers: AnyArray) -> Floats:
    """Where corrected ghosts go, (k, 3) metres, in the order of `plan.ghosts`."""
    scan = state.scan(plan.scan).scan
    scanner = scan.scanner("the correction of ghosts")
    places = answers == Answer.CORRECT
    xyz = scan.xyz[plan.ghosts[places]]
    beams = xyz - scanner
    moved: Floats = xyz + beams * (plan.shift[places] / np.linalg.norm(beams, axis=1))[:, None]
    return moved


def describe_answers(answers: AnyArray) -> str:
    """``Clean up: 812 ghosts corrected, 40 deleted``."""
    counts = {word: int((answers == answer).sum()) for answer, word in WORDS.items()}
    said = ", ".join(f"{group_digits(n)} {word}" for word, n in counts.items() if n)
    return f"Clean up ghosts: {said or 'nothing to do'}"


def _join_leaves(state: State, plan: Plan, answers: AnyArray) -> list[AnyOperation]:
    """Corrected points become members of the leaves onto which they come back."""
    places = np.flatnonzero((answers == Answer.CORRECT) & (plan.leaf >= 0))
    places = places[plan.names.of[plan.ghosts[places]] < 0]
    steps: list[AnyOperation] = []
    for number in np.unique(plan.leaf[places]):
        leaf = state.leaves.get(plan.names.keys[int(number)])
        if leaf is None:
            continue
        fresh = PointSet(plan.ghosts[places[plan.leaf[places] == number]])
        joined = replace(leaf, members=leaf.members | fresh, basis=(*leaf.basis, Explicit(fresh)))
        steps.append(PutLeaf(leaf.key, joined, "Extend"))
    return steps
