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
LARGEST = 30.0
"""Of the logit: beyond it, a probability is 0 or 1 to all digits."""


class Stored(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A network as it lies in its file: weights and offsets of each layer."""

    about: str
    evidence: tuple[str, ...]
    weights: tuple[tuple[tuple[float, ...], ...], ...]
    offsets: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Layers of weighted sums, negative ones cut off between them; the last gives a logit.

    Attributes
    ----------
    weights : of (inputs, outputs) float32
    offsets : of (outputs,) float32
    """

    weights: tuple[AnyArray, ...]
    offsets: tuple[AnyArray, ...]

    def weigh(self, evidence: AnyArray) -> Floats:
        """Probability that the evidence of each row, (n, inputs), tells; (n,) of 0 to 1."""
        signal = evidence
        for weight, offset in zip(self.weights[:-1], self.offsets[:-1], strict=True):
            signal = signal @ weight
            signal += offset
            np.maximum(signal, 0.0, out=signal)
        logit = (signal @ self.weights[-1] + self.offsets[-1])[:, 0].astype(np.float64)
        return 1.0 / (1.0 + np.exp(-np.clip(logit, -LARGEST, LARGEST)))


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
    inputs = len(stored.evidence)
    for weight, offset in zip(weights, offsets, strict=True):
        if weight.shape != (inputs, len(offset)):
            raise WrongUse(f"A layer of {weight.shape} weights cannot follow {inputs} numbers.")
        inputs = len(offset)
    if inputs != 1:
        raise WrongUse(f"A network ends in one number, not in {inputs}.")
    return Network(weights, offsets)
