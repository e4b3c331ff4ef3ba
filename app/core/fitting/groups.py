"""Many sets of pairs (angle, value), as a caller gives them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from app.core.arrays import Bools, Floats, Ints
from app.core.errors import BadInput
from app.core.fitting.pairs import as_numbers


@dataclass(frozen=True, slots=True, eq=False)
class Flat:
    """Usable pairs of some groups, one group after the other."""

    angle: Floats
    value: Floats
    weight: Floats
    starts: Ints
    counts: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Groups side by side, or one after the other where `offsets` tell their borders.

    Attributes
    ----------
    angle : (g or 1, n) or (N,) array
    value : (g, n) or (N,) array
    weight : (g or 1, n) or (N,) array, or None
    offsets : (g + 1,) array or None
    """

    angle: Floats
    value: Floats
    weight: Floats | None
    offsets: Ints | None

    def __len__(self) -> int:
        return len(self.value) if self.offsets is None else len(self.offsets) - 1

    def pick(self, group: int) -> tuple[Floats, Floats, Floats | None]:
        """Angles, values and weights of one group."""
        if self.offsets is None:
            angle = self.angle[group if len(self.angle) > 1 else 0]
            weight = self.weight
            if weight is not None:
                weight = weight[group if len(weight) > 1 else 0]
            return angle, self.value[group], weight
        part = slice(int(self.offsets[group]), int(self.offsets[group + 1]))
        return (
            self.angle[part],
            self.value[part],
            None if self.weight is None else self.weight[part],
        )

    def flatten(self, rows: Ints, usable: Bools) -> Flat:
        """The pairs of `rows` that are `usable`, an array like `value`."""
        weight = np.ones(1) if self.weight is None else self.weight
        if self.offsets is None:
            usable = usable[rows]
            shape = usable.shape

            def choose(array: Floats) -> Floats:
                array = array[rows] if len(array) == len(self) > 1 else array
                return np.broadcast_to(array, shape)[usable]

            flat = choose(self.angle), self.value[rows][usable], choose(weight)
            counts = usable.sum(axis=1)
        else:
            flat = (
                self.angle[usable],
                self.value[usable],
                np.broadcast_to(weight, len(usable))[usable],
            )
            before = np.concatenate(([0], np.cumsum(usable)))
            counts = np.diff(before[self.offsets])
        return Flat(*flat, np.cumsum(counts) - counts, counts)


def read_groups(
    angle: npt.ArrayLike,
    value: npt.ArrayLike,
    weights: npt.ArrayLike | None,
    offsets: npt.ArrayLike | None,
) -> Groups:
    """Check that the arrays fit together.

    Raises
    ------
    BadInput
        Lengths differ, borders fall, something is no number, or a weight is negative.
    """
    angle, value = as_numbers("angle", angle), as_numbers("value", value)
    weight = None if weights is None else as_numbers("weight", weights)
    if weight is not None and (weight < 0).any():
        raise BadInput("A weight is negative.", "Weights are 1/σ² or counts.")
    if offsets is None:
        if value.ndim != 2:
            raise BadInput("Groups of pairs need a table of values, (groups, angles), or offsets.")
        angle = _match("angles", angle, value)
        return Groups(
            angle, value, None if weight is None else _match("weights", weight, value), None
        )
    borders = np.asarray(offsets, np.int64).ravel()
    flat = [array for array in (angle, value, weight) if array is not None]
    if any(array.ndim != 1 or len(array) != borders[-1] for array in flat):
        raise BadInput("The last offset must be the number of angles, of values and of weights.")
    if borders[0] != 0 or (np.diff(borders) < 0).any():
        raise BadInput("Offsets begin with 0 and must not fall.")
    return Groups(angle, value, weight, borders)


def _match(what: str, array: Floats, value: Floats) -> Floats:
    wide = array[None] if array.ndim == 1 else array
    if wide.shape not in ((1, value.shape[1]), value.shape):
        raise BadInput(
            f"A table of {value.shape[0]} × {value.shape[1]} values needs {value.shape[1]} {what},"
            f" or as many as values; there are {array.shape}."
        )
    return wide
