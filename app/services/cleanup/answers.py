"""What can be answered of a ghost, and how strict the search for ghosts is."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal

import numpy as np

from app.core.arrays import AnyArray, Bools, Ints
from app.core.units import group_digits
from app.model.operations import AnyOperation, MarkGhosts, Several
from app.model.points import PointSet

Setting = Literal["careful", "normal", "strict"]
Uncertain = Literal["delete", "mark"]
"""What becomes of ghosts that cannot be corrected."""

SETTINGS: dict[Setting, float] = {"careful": 0.8, "normal": 0.5, "strict": 0.2}
"""Thresholds: few good points lost; most right in all; few ghosts left."""


class Answer(IntEnum):
    """What is to become of a ghost; the values are the marks of `ScanState`."""

    KEEP = -1
    """It is none: it stays as it is."""
    LEAVE = 1
    """It stays, marked as a ghost."""
    DELETE = 2
    CORRECT = 3


WORDS = {
    Answer.CORRECT: "corrected",
    Answer.DELETE: "deleted",
    Answer.KEEP: "kept",
    Answer.LEAVE: "left marked",
}


def is_answer(marks: AnyArray) -> Bools:
    """Which marks are the user's word; a mark as ghost alone leaves open what to do with it."""
    answered: Bools = (marks != 0) & (marks != Answer.LEAVE)
    return answered


def answer_ghosts(
    scan: str, points: Ints, answer: Answer | None, batch: str = "", every: AnyArray | None = None
) -> AnyOperation:
    """The step that writes an answer for some ghosts into the document.

    Parameters
    ----------
    answer : Answer or None
        None takes answers back.
    batch : str
        What the ghosts are, for the history: "Leaf 7".
    every : (k,) or None
        An answer for each point instead: proposals that are accepted.
    """
    answers = np.full(len(points), 0 if answer is None else answer) if every is None else every
    kept, cleared, ghosts, deleting, correcting = (
        PointSet(points[answers == value]) for value in (-1, 0, 1, 2, 3)
    )
    step = MarkGhosts(scan, ghosts, kept, cleared, None, deleting, correcting)
    return Several(_title(len(points), answer, batch, every is not None), (step,))


def _title(count: int, answer: Answer | None, batch: str, accepted: bool) -> str:
    ghosts = f"{group_digits(count)} {'ghost' if count == 1 else 'ghosts'}"
    of = f" of {batch}" if batch else ""
    if accepted:
        return f"Accept proposals for {ghosts}{of}"
    if answer is None:
        return f"Take back answers for {ghosts}{of}"
    verb = {-1: "keep", 1: "leave marked", 2: "delete", 3: "correct"}[int(answer)]
    return f"Answer “{verb}” for {ghosts}{of}"
