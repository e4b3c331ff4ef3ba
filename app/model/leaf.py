"""Leaves: the unit of analysis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from app.core.arrays import Ints
from app.model.fit_method import Method, usual_method
from app.model.points import PointSet
from app.model.selection import Selection


class Leaf(msgspec.Struct, frozen=True):
    """A leaf of one scan: its members and the selections that gathered them.

    `key` never changes; `name` is what the user calls it.
    """

    key: str
    scan: str
    name: str
    members: PointSet
    basis: tuple[Selection, ...] = ()


class FitRecord(msgspec.Struct, frozen=True):
    """A fit as it was made: on which leaves, channel and model, and its result.

    `result` is the plain form of `app.core.fitting.FitResult`; `method` tells how it was
    fitted, None as usual (see `usual_method`). A formula model is part of the result.
    """

    key: str
    scan: str
    leaves: tuple[str, ...]
    channel: str
    model: str
    result: dict[str, Any]
    method: Method | None = None
    fixed: dict[str, float] = {}

    @property
    def method_used(self) -> Method:
        """How it was fitted."""
        return self.method or usual_method(self.leaves)


class Sample(msgspec.Struct, frozen=True):
    """Scans of the same sample by several instruments; their points are never paired."""

    key: str
    name: str
    scans: tuple[str, ...]


def join_members(leaves: Sequence[Leaf], size: int) -> Ints:
    """Points of leaves in rising order, each once; `size` is the number of points of the scan.

    By a mask: sorting millions of numbers would hold the window up.
    """
    if len(leaves) == 1:
        return leaves[0].members.indices
    mask = np.zeros(size, bool)
    for leaf in leaves:
        mask[leaf.members.indices] = True
    return np.flatnonzero(mask)
