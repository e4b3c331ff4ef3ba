"""Groups of pairs side by side in arrays, so that many are fitted at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.core.fitting.groups import Groups
from app.core.fitting.pairs import LARGEST, Pairs
from app.core.phase import PhaseModel

# Pairs side by side: enough to keep numpy busy, few enough for the cache.
SIZE = 40_000
# Share by which a group may be filled up.
FILL = 1.25
# Angles that are looked at before all of them are.
FEW = 64


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Groups of about the same size; short ones are filled up with pairs of weight 0.

    Attributes
    ----------
    rows : (b,) array
        Numbers of the groups.
    angle : (b or 1, n) array
        Radians.
    value : (b, n) array
        Divided by `scale`.
    weight : (b or 1, n) array
        Divided by `weight_scale`.
    count : (b,) array
        Pairs of each group.
    scale, weight_scale : (b,) arrays
    """

    rows: Ints
    angle: Floats
    value: Floats
    weight: Floats
    count: Ints
    scale: Floats
    weight_scale: Floats

    def __len__(self) -> int:
        return len(self.rows)

    def take(self, chosen: Bools) -> Block:
        """Some of the groups."""

        def choose(array: Floats) -> Floats:
            return array if len(array) == 1 and len(self) > 1 else array[chosen]

        return Block(
            self.rows[chosen], choose(self.angle), self.value[chosen], choose(self.weight),
            self.count[chosen], self.scale[chosen], self.weight_scale[chosen],
        )  # fmt: skip

    def count_angles(self, enough: int) -> Ints:
        """Different angles of each group, (b,); where there are `enough`, perhaps too few."""
        found = _count_different(self.angle[:, :FEW])
        for row in np.flatnonzero(found < enough):
            found[row] = len(np.unique(self.angle[row]))
        return np.broadcast_to(found, len(self))


def hold_pairs(pairs: Pairs) -> Block:
    """A block of one group."""
    return Block(
        np.zeros(1, np.int64), pairs.angle[None], pairs.value[None], pairs.weight[None],
        np.array([len(pairs)]), np.array([pairs.scale]), np.array([pairs.weight_scale]),
    )  # fmt: skip


def arrange_blocks(model: PhaseModel, groups: Groups) -> Iterator[Block]:
    """All groups with at least one usable pair, in blocks; pairs that cannot be fitted left out."""
    usable = _find_usable(model, groups)
    rest: Ints = np.arange(len(groups))
    if groups.offsets is None:
        whole = usable.all(axis=1)
        for rows in _cut(np.flatnonzero(whole), groups.value.shape[1]):
            weight = groups.weight
            yield _scale_block(
                rows,
                groups.angle if len(groups.angle) == 1 else groups.angle[rows],
                groups.value[rows],
                np.ones((1, groups.value.shape[1])) if weight is None
                else weight if len(weight) == 1 else weight[rows],
                np.full(len(rows), groups.value.shape[1]),
            )  # fmt: skip
        rest = np.flatnonzero(~whole)
    yield from _arrange_ragged(groups, rest, usable)


def _find_usable(model: PhaseModel, groups: Groups) -> Bools:
    usable: Bools = (
        np.isfinite(groups.angle) & model.accepts(groups.angle) & (np.abs(groups.value) < LARGEST)
    )
    if groups.weight is not None:
        usable = usable & np.isfinite(groups.weight) & (groups.weight > 0)
    return usable


def _cut(rows: Ints, n: int) -> Iterator[Ints]:
    size = max(1, SIZE // max(n, 1))
    for first in range(0, len(rows), size):
        yield rows[first : first + size]


def _arrange_ragged(groups: Groups, rows: Ints, usable: Bools) -> Iterator[Block]:
    flat = groups.flatten(rows, usable)
    order = np.argsort(flat.counts, kind="stable")
    order = order[flat.counts[order] > 0]
    first = 0
    while first < len(order):
        counts = flat.counts[order[first:]]
        fits = (counts <= counts[0] * FILL + 1) & (counts * np.arange(1, len(counts) + 1) <= SIZE)
        size = max(1, int(np.argmin(fits)) if not fits.all() else len(fits))
        some = order[first : first + size]
        place = flat.starts[some, None] + np.arange(flat.counts[some].max())
        last = (flat.starts + flat.counts - 1)[some, None]
        inside = place <= last
        # A pair that only fills up repeats the last angle, where every column is finite.
        place = np.minimum(place, last)
        yield _scale_block(
            rows[some],
            flat.angle[place],
            np.where(inside, flat.value[place], 0.0),
            np.where(inside, flat.weight[place], 0.0),
            flat.counts[some],
        )
        first += size


def _scale_block(rows: Ints, angle: Floats, value: Floats, weight: Floats, count: Ints) -> Block:
    scale = np.abs(value).max(axis=1)
    scale[scale == 0.0] = 1.0
    heaviest = np.broadcast_to(weight.max(axis=1), len(rows))
    weight = weight / weight.max(axis=1, keepdims=True)
    return Block(rows, angle, value / scale[:, None], weight, count, scale, heaviest)


def _count_different(angle: Floats) -> Ints:
    ordered = np.sort(angle, axis=1)
    counts: Ints = 1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1)
    return counts
