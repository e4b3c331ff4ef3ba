"""What the document tells those who watch it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

Aspect = Literal[
    "scans",
    "points",
    "pose",
    "channels",
    "deleted",
    "ghosts",
    "selection",
    "parameters",
    "leaves",
    "fits",
    "samples",
    "series",
    "fields",
]


@dataclass(frozen=True, slots=True)
class Change:
    """What became different: aspects, and the fields that were computed."""

    aspects: frozenset[Aspect]
    fields: frozenset[str] = frozenset()


EVERYTHING = Change(frozenset(get_args(Aspect)))
