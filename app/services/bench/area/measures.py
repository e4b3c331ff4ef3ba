"""Figures of segmentations and of areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints

SAME = 0.5
"""Intersection over union from which a segment is a leaf."""
FEWEST = 50
"""Full hits that a leaf has at least, to be judged."""


@dataclass(frozen=True, slots=True)
class Match:
    """Leaves found, missed, and segments that are no leaf; segment of each leaf or -1."""

    found: int
    missed: int
    false: int
    segment: Ints

    @property
    def f1(self) -> float:
        """2 · found / (2 · found + missed + false)."""
        return 2 * self.found / max(2 * self.found + self.missed + self.false, 1)


def match_segments(label: AnyArray, leaf: AnyArray, full: Bools, judged: Bools) -> Match:
    """Compare segments with true leaves over the judged points.

    A segment that lies mostly on a leaf of fewer than 50 full hits counts for nothing.
    """
    leaves, segments = int(leaf.max(initial=-1)) + 1, int(label.max(initial=-1)) + 1
    true, got = (leaf >= 0) & judged, (label >= 0) & judged
    large = np.bincount(leaf[true & full], minlength=leaves) >= FEWEST
    both = true & got
    pair = np.bincount(leaf[both] * segments + label[both], minlength=leaves * segments)
    pair = pair.reshape(leaves, segments)
    size = np.bincount(leaf[true], minlength=leaves), np.bincount(label[got], minlength=segments)
    union = size[0][:, None] + size[1] - pair
    same = pair > SAME * union
    segment = (
        np.where(same.any(axis=1), same.argmax(axis=1), -1) if segments else np.full(leaves, -1)
    )
    if not segments or not leaves:
        return Match(0, int(large.sum()), segments, segment)
    small = (pair.max(axis=0) > SAME * size[1]) & ~large[pair.argmax(axis=0)]
    false = int((~same.any(axis=0) & ~small).sum())
    return Match(
        int((large & (segment >= 0)).sum()), int((large & (segment < 0)).sum()), false, segment
    )


@dataclass(frozen=True, slots=True)
class Measured:
    """One leaf's area by one way: relative error, whether the interval holds the truth."""

    kind: str
    error: float
    held: bool
    width: float


def summarise(measured: Sequence[Measured]) -> dict[str, float | int]:
    """Median, 90 % and largest error, coverage and mean half width, in percent."""
    errors: Floats = np.array([m.error for m in measured])
    known = errors[np.isfinite(errors)]
    if not len(known):
        return {
            "leaves": len(measured),
            **dict.fromkeys(("median", "p90", "largest", "covered", "interval"), np.nan),
        }
    return {
        "leaves": len(measured),
        "median": round(100 * float(np.median(known)), 3),
        "p90": round(100 * float(np.quantile(np.abs(known), 0.9)), 3),
        "largest": round(100 * float(np.abs(known).max()), 3),
        "covered": round(100 * float(np.mean([m.held for m in measured])), 2),
        "interval": round(100 * float(np.mean([m.width for m in measured])), 2),
    }
