"""Leaves: the unit of analysis."""

from __future__ import annotations

from typing import Any

import msgspec

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

    `result` is the plain form of `app.core.fitting.FitResult`.
    """

    key: str
    scan: str
    leaves: tuple[str, ...]
    channel: str
    model: str
    result: dict[str, Any]


class Sample(msgspec.Struct, frozen=True):
    """Scans of the same sample by several instruments; their points are never paired."""

    key: str
    name: str
    scans: tuple[str, ...]
