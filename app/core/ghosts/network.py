"""Small networks that weigh evidence; what they learned stands in `resources/ghosts`.

They learned on simulated scans (`app.services.bench.ghosts.training`), where the truth is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Literal

import msgspec
import numpy as np

from app.core.arrays import AnyArray, Floats
from app.core.errors import WrongUse

Name = Literal["glance", "judgement", "confidence"]
LAYERS = 3


class Stored(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A network as it lies in its file: weights and offsets of each layer."""

    about: str
    evidence: tuple[str, ...]
    weights: tuple[tuple[tuple[float, ...], ...], ...]
    offsets: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Three layers of weighted sums, negative ones cut off between them; the last gives a logit.

    Attributes
    ----------
    weights : of (inputs, outputs) float32
    offsets : of (outputs,) float32
    """

    weights: tuple[AnyArray, ...]
    offsets: tuple[AnyArray, ...]

    def weigh(self, evidence: AnyArray) -> Floats:
        """Probability that the evidence of each row, (n, inputs) float32, tells; (n,) of 0 to 1.

        Raises
        ------
        WrongUse
            The rows have another number of inputs.
        """
        from app.core.kernels.small_network import weigh

        if evidence.shape[1:] != self.weights[0].shape[:1]:
            raise WrongUse(f"Evidence of {evidence.shape} does not fit {self.weights[0].shape}.")
        said = np.empty(len(evidence))
        weigh(evidence, *self.layers, said)
        return said

    @property
    def layers(self) -> tuple[AnyArray, ...]:
        """Weights and offsets of one layer after the other."""
        pairs = zip(self.weights, self.offsets, strict=True)
        return tuple(array for pair in pairs for array in pair)


@cache
def load_network(name: Name) -> Network:
    """The network of that name; read once."""
    text = (files("resources") / "ghosts" / f"{name}.json").read_bytes()
    return build_network(msgspec.json.decode(text, type=Stored))


def build_network(stored: Stored) -> Network:
    """A network from its file.

    Raises
    ------
    WrongUse
        Its layers do not fit one another.
    """
    weights = tuple(np.array(rows, np.float32, ndmin=2) for rows in stored.weights)
    offsets = tuple(np.array(row, np.float32) for row in stored.offsets)
    if len(weights) != LAYERS:
        raise WrongUse(f"A network has {LAYERS} layers, not {len(weights)}.")
    inputs = len(stored.evidence)
    for weight, offset in zip(weights, offsets, strict=True):
        if weight.shape != (inputs, len(offset)):
            raise WrongUse(f"A layer of {weight.shape} weights cannot follow {inputs} numbers.")
        inputs = len(offset)
    if inputs != 1:
        raise WrongUse(f"A network ends in one number, not in {inputs}.")
    return Network(weights, offsets)
