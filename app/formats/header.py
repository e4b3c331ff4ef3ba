"""What the header of a file claims, checked against the file before anything is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Header:
    """Result of a preflight.

    Attributes
    ----------
    points : int
        Points (cells with an echo or without, where the header cannot tell them apart).
    scans : int
    attributes : tuple of str
        Names of everything beside the coordinates.
    memory : int
        Estimated bytes at the peak of reading.
    details : mapping of str to str
        Facts for a user to read: version, encoding, layout.
    warnings : tuple of str
    """

    points: int
    scans: int = 1
    attributes: tuple[str, ...] = ()
    memory: int = 0
    details: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
