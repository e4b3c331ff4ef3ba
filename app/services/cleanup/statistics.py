"""What a clean-up changes, in numbers: by answer, by reason, by leaf, and how far points move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.core.arrays import AnyArray, Bools
from app.core.ghosts import WORDS as REASONS
from app.core.units import to_mm
from app.services.cleanup.answers import WORDS, Answer
from app.services.cleanup.plan import Plan

UNKNOWN = "not known without rows and columns"


@dataclass(frozen=True, slots=True)
class LeafChange:
    """What becomes of one leaf, in points.

    Attributes
    ----------
    name : str
    before, after : int
    ghosts : int
        Of the leaf, or whose nearest surface it is.
    corrected, deleted : int
        Of these.
    """

    name: str
    before: int
    after: int
    ghosts: int
    corrected: int
    deleted: int


@dataclass(frozen=True, slots=True)
class Statistics:
    """Counts of one clean-up.

    Attributes
    ----------
    points : int
        Living points before.
    ghosts : int
    by_answer : mapping of str to int
        All answers, also those that nobody gave; ``open`` counts ghosts that are left alone.
    by_reason : mapping of str to (mapping of str to int)
        The same for each reason that occurs.
    leaves : tuple of LeafChange
    shift_median, shift_95 : float or None
        Of how far corrected points move, mm, whatever the sign.
    """

    points: int
    ghosts: int
    by_answer: Mapping[str, int]
    by_reason: Mapping[str, Mapping[str, int]]
    leaves: tuple[LeafChange, ...]
    shift_median: float | None
    shift_95: float | None

    def as_json(self) -> dict[str, Any]:
        """Plain names and numbers."""
        return {
            "points": self.points,
            "ghosts": self.ghosts,
            **{word.replace(" ", "_"): count for word, count in self.by_answer.items()},
            "reasons": {reason: dict(counts) for reason, counts in self.by_reason.items()},
            "shift_median_mm": self.shift_median,
            "shift_95_mm": self.shift_95,
            "leaves": [
                {name: getattr(leaf, name) for name in LeafChange.__slots__} for leaf in self.leaves
            ],
        }


def sum_up(plan: Plan, answers: AnyArray, alive: Bools) -> Statistics:
    """Count what answers would change, or did.

    Parameters
    ----------
    plan : Plan
    answers : (g,) int8
    alive : (n,) bool
        Points that exist before the clean-up.
    """
    shift = to_mm(np.abs(plan.shift[answers == Answer.CORRECT]))
    known = len(shift) > 0
    return Statistics(
        int(np.count_nonzero(alive)),
        len(plan),
        _count(answers),
        _count_reasons(plan, answers),
        _count_leaves(plan, answers, alive),
        float(np.median(shift)) if known else None,
        float(np.quantile(shift, 0.95)) if known else None,
    )


def _count(answers: AnyArray) -> dict[str, int]:
    counts = {word: int((answers == answer).sum()) for answer, word in WORDS.items()}
    return counts | {"open": int((answers == 0).sum())}


def _count_reasons(plan: Plan, answers: AnyArray) -> dict[str, dict[str, int]]:
    if plan.reasons is None:
        return {UNKNOWN: _count(answers)} if len(plan) else {}
    reason = plan.reasons.reason
    return {
        word: _count(answers[reason == number])
        for number, word in REASONS.items()
        if (reason == number).any()
    }


def _count_leaves(plan: Plan, answers: AnyArray, alive: Bools) -> tuple[LeafChange, ...]:
    size = len(plan.names.keys)
    if not size:
        return ()

    def count(places: AnyArray) -> AnyArray:
        return np.bincount(places[places >= 0], minlength=size)

    corrected, deleted = answers == Answer.CORRECT, answers == Answer.DELETE
    own = plan.names.of[plan.ghosts]
    before = count(plan.names.of[alive])
    after = before - count(own[deleted]) + count(plan.leaf[corrected & (own < 0)])
    columns = (before, after, count(plan.leaf), count(plan.leaf[corrected]),
               count(plan.leaf[deleted]))  # fmt: skip
    return tuple(
        LeafChange(name, *(int(column[place]) for column in columns))
        for place, name in enumerate(plan.names.names)
    )
