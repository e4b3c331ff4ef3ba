"""Sets of points: what leaves, selections and operations are made of."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from app.core.arrays import Bools, Ints


class PointSet:
    """An immutable, sorted set of row numbers of one scan.

    Parameters
    ----------
    indices : iterable of int or int array
        Row numbers in any order; repeats are dropped.
    """

    __slots__ = ("indices",)
    indices: Ints

    def __init__(self, indices: Iterable[int] | Ints = ()) -> None:
        if not isinstance(indices, np.ndarray):
            indices = np.fromiter(indices, np.int64)
        ordered = _put_in_order(np.array(indices, np.int64))
        ordered.flags.writeable = False
        object.__setattr__(self, "indices", ordered)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("a PointSet does not change")

    @classmethod
    def from_mask(cls, mask: Bools) -> PointSet:
        """The points where an (n,) mask is true."""
        return cls(np.flatnonzero(mask))

    def mask(self, size: int) -> Bools:
        """(size,) booleans that are true at the points of the set."""
        mask = np.zeros(size, bool)
        mask[self.indices] = True
        return mask

    def __len__(self) -> int:
        return len(self.indices)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PointSet):
            return NotImplemented
        return np.array_equal(self.indices, other.indices)

    def __hash__(self) -> int:
        return hash(self.indices.tobytes())

    def __repr__(self) -> str:
        return f"PointSet({len(self)} points)"

    def __or__(self, other: PointSet) -> PointSet:
        return PointSet(np.concatenate((self.indices, other.indices)))

    def __sub__(self, other: PointSet) -> PointSet:
        return PointSet(np.setdiff1d(self.indices, other.indices, assume_unique=True))

    def __and__(self, other: PointSet) -> PointSet:
        return PointSet(np.intersect1d(self.indices, other.indices, assume_unique=True))


def _put_in_order(indices: Ints) -> Ints:
    # Most sets come sorted, and np.unique would hash them: seconds for millions of points.
    if (indices[1:] > indices[:-1]).all():
        return indices
    ordered = np.sort(indices)
    fresh = np.ones(len(ordered), bool)
    fresh[1:] = ordered[1:] != ordered[:-1]
    return ordered[fresh]


EMPTY = PointSet()
