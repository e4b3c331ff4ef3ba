"""Which points are asked for, and where their results go."""

from __future__ import annotations

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints, read_only
from app.core.errors import WrongUse


def as_points(xyz: AnyArray) -> Floats:
    """Coordinates of the one array type that the kernels are compiled for; copies if need be."""
    points: Floats = read_only(np.ascontiguousarray(xyz, dtype=np.float64))
    return points


def each_once(points: Ints | None, total: int) -> tuple[Ints | None, Ints | slice]:
    """Asked points once each and rising, and the place of each request among them.

    Raises
    ------
    WrongUse
        A point number does not exist.
    """
    if points is None:
        return None, slice(None)
    asked = np.asarray(points, dtype=np.int64)
    where: Ints | slice = slice(None)
    if not (np.diff(asked) > 0).all():  # most requests are sorted: then there is nothing to do
        asked, where = np.unique(asked, return_inverse=True)
    if len(asked) and (asked[0] < 0 or asked[-1] >= total):
        wrong = asked[0] if asked[0] < 0 else asked[-1]
        raise WrongUse(f"Point {wrong} was asked for; the scan has {total} points.")
    return asked, where


def slots_of(asked: Ints | None, total: int) -> AnyArray:
    """For each point of the scan, the place of its result, or -1; (total,) integers."""
    kind = np.int32 if total < 2**31 else np.int64
    if asked is None:
        return np.arange(total, dtype=kind)
    slot = np.full(total, -1, kind)
    slot[asked] = np.arange(len(asked))
    return slot
