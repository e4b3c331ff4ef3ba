"""Level of detail: a shuffled order in fixed blocks, and how many points a frame can afford."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import Ints

FIRST_BLOCK = 65_536
LARGEST_BLOCK = 262_144
Block = tuple[int, int]


def shuffle_points(count: int, seed: int = 0) -> Ints:
    """An order in which every prefix is a fair sample; the same for the same count.

    Returns
    -------
    (count,) int64
        Row numbers, each once.
    """
    return np.random.default_rng(seed).permutation(count)


def split_blocks(count: int) -> tuple[Block, ...]:
    """Bounds (start, stop) of the blocks of a shuffled order.

    The prefixes double up to `LARGEST_BLOCK` and then grow by that much, so that a frame can
    be refined in steps that never hold the window up for long.
    """
    bounds: list[Block] = []
    start = 0
    while start < count:
        size = min(max(start, FIRST_BLOCK), LARGEST_BLOCK)
        bounds.append((start, min(start + size, count)))
        start = bounds[-1][1]
    return tuple(bounds)


def count_blocks(blocks: tuple[Block, ...], points: float, drawn: int = 0) -> int:
    """How many blocks after the first `drawn` ones fit into a number of points; at least one."""
    start = blocks[drawn][0] if drawn < len(blocks) else 0
    fitting = sum(1 for _, stop in blocks[drawn:] if stop - start <= points)
    return max(1, fitting) if drawn < len(blocks) else 0


@dataclass(slots=True)
class FrameBudget:
    """Learns how fast this machine draws.

    Attributes
    ----------
    target : float
        Seconds that a frame may take while the camera moves.
    rate : float
        Points per second, learnt from the frames so far.
    """

    target: float = 0.08
    rate: float = 2e6

    def record(self, points: int, seconds: float) -> None:
        """Learn from a frame. Small frames tell about their overhead only and are left out."""
        if points < FIRST_BLOCK // 2 or seconds <= 0.0:
            return
        # A slow frame counts at once, a fast one slowly: the hand notices a stutter first.
        seen = points / seconds
        weight = 0.7 if seen < self.rate else 0.3
        self.rate += weight * (seen - self.rate)

    @property
    def points(self) -> int:
        """Points that a frame may hold."""
        return int(self.rate * self.target)
