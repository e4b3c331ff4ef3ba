"""The order in which ghosts are looked at: the doubtful ones first, a leaf at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Ints
from app.core.ghosts import WORDS as REASONS
from app.services.cleanup.plan import Plan

STEP = 0.1
"""Of doubt; ghosts of one step come leaf by leaf, so that the eye stays where it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Ghosts that can be answered together: a leaf's, or those of one reason.

    Attributes
    ----------
    name : str
        As in "of Leaf 7".
    places : (k,)
        Into `Plan.ghosts`, in the order of the queue.
    """

    name: str
    places: Ints


def order_by_doubt(plan: Plan) -> Ints:
    """Places into `plan.ghosts`: where score and threshold are nearest comes first."""
    doubt = np.abs(plan.score - plan.threshold)
    coarse = np.floor(np.nan_to_num(doubt, nan=0.0) / STEP)
    leaf = np.where(plan.leaf < 0, len(plan.names.keys), plan.leaf)
    order: Ints = np.lexsort((doubt, leaf, coarse))
    return order


def list_batches(plan: Plan, order: Ints) -> list[Batch]:
    """All ghosts, then those of each leaf, then those of each reason; none is empty."""
    batches = [Batch("", order)]
    leaf = plan.leaf[order]
    for number, name in enumerate(plan.names.names):
        batches.append(Batch(name, order[leaf == number]))
    if plan.names.names:
        batches.append(Batch("no leaf", order[leaf < 0]))
    if plan.reasons is not None:
        reason = plan.reasons.reason[order]
        batches += [Batch(word, order[reason == number]) for number, word in REASONS.items()]
    return [batch for batch in batches if len(batch.places)]
