"""Digitised records of what came back, one per point at most, read when somebody asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints

MOST_SAMPLES = 2_000_000
"""Samples that are held at a time; a single longer record is held all the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Packets:
    """The waveforms of k points.

    Attributes
    ----------
    samples : (m,) volts, one waveform after the other
    offsets : (k + 1,)
        Waveform i is ``samples[offsets[i]:offsets[i + 1]]``; empty where a point has none.
    step_ns : (k,) time between samples
    place : (k,) where the point's return is, in samples from the first
    quantum : (k,) volts, step of the digitiser
    ceiling : (k,) volts, from where on samples are saturated
    """

    samples: Floats
    offsets: Ints
    step_ns: Floats
    place: Floats
    quantum: Floats
    ceiling: Floats


class Waveforms(Protocol):
    """The waveforms of a scan, in the order of its points; they never change."""

    def __len__(self) -> int:
        """Number of points."""

    def count_samples(self, points: Ints) -> Ints:
        """Samples of each point's waveform, 0 where it has none; raises as `read`."""

    def read(self, points: Ints) -> Packets:
        """The waveforms of some points.

        Raises
        ------
        BadInput
            The file that holds them is missing, has changed, or cannot be understood.
        """

    def take(self, points: AnyArray) -> Waveforms:
        """Those of some points, (k,) numbers or (n,) booleans."""


def split_points(waveforms: Waveforms, points: Ints, most: int = MOST_SAMPLES) -> list[Ints]:
    """The points in pieces whose waveforms have about `most` samples together."""
    total = np.cumsum(waveforms.count_samples(points))
    piece = (total - 1) // most if len(total) else total
    return np.split(points, np.flatnonzero(np.diff(piece) > 0) + 1)
