"""Teaching a small network: logistic loss, Adam, and the same result each time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from app.core.arrays import AnyArray, Bools
from app.core.ghosts.network import Stored

RATE = 3e-3
DECAY = 1e-4
MEMORY = (0.9, 0.999)
TINY = 1e-8
DIGITS = 6


def teach(
    about: str, names: tuple[str, ...], evidence: AnyArray, truth: Bools,
    hidden: tuple[int, ...], rounds: int, batch: int, seed: int = 0,
) -> Stored:  # fmt: skip
    """A network that tells how likely `truth` is, by the evidence of each row.

    Parameters
    ----------
    about : str
        What it tells, for its file.
    names : tuple of str
        Of the columns.
    evidence : (n, names) array
    truth : (n,) bool
    hidden : tuple of int
        Sums in each layer.
    rounds : int
        How often all rows are seen.
    batch : int
        Rows per step.
    seed : int

    Raises
    ------
    WrongUse
        There are fewer rows than in a batch.
    """
    random = np.random.default_rng(seed)
    centre, spread = evidence.mean(axis=0), evidence.std(axis=0) + 1e-3
    rows = ((evidence - centre) / spread).astype(np.float32)
    wanted = truth.astype(np.float32)
    layers = _draw_layers((evidence.shape[1], *hidden, 1), random)
    steps = max(1, rounds * (len(rows) // batch))
    pace = _Adam(layers, steps)
    for _ in range(rounds):
        order = random.permutation(len(rows))
        for first in range(0, len(rows) - batch + 1, batch):
            some = order[first : first + batch]
            pace.step(_slope(layers, rows[some], wanted[some]))
    # The network then takes the evidence as it is.
    layers[1] = layers[1] - (centre / spread).astype(np.float32) @ layers[0]
    layers[0] = layers[0] / spread.astype(np.float32)[:, None]
    return _store(about, names, layers)


def _draw_layers(sizes: tuple[int, ...], random: np.random.Generator) -> list[AnyArray]:
    """Weights and offsets of each layer in turn."""
    layers: list[AnyArray] = []
    for inputs, outputs in pairwise(sizes):
        weights = random.normal(0.0, np.sqrt(2.0 / inputs), (inputs, outputs))
        layers += [weights.astype(np.float32), np.zeros(outputs, np.float32)]
    return layers


def _slope(layers: list[AnyArray], rows: AnyArray, wanted: AnyArray) -> list[AnyArray]:
    """Derivative of the mean loss by each layer."""
    signals = [rows]
    for k in range(0, len(layers) - 2, 2):
        signals.append(np.maximum(signals[-1] @ layers[k] + layers[k + 1], 0.0))
    logit = (signals[-1] @ layers[-2] + layers[-1])[:, 0]
    told = 1.0 / (1.0 + np.exp(-np.clip(logit, -30.0, 30.0)))
    miss = ((told - wanted) / len(rows))[:, None].astype(np.float32)
    slope = [np.empty(0, np.float32)] * len(layers)
    for k in range(len(layers) - 2, -1, -2):
        slope[k], slope[k + 1] = signals[k // 2].T @ miss, miss.sum(axis=0)
        if k:
            miss = (miss @ layers[k].T) * (signals[k // 2] > 0.0)
    return slope


class _Adam:
    """Steps down the slope, at a pace of its own for each weight, slower towards the end."""

    def __init__(self, layers: list[AnyArray], steps: int) -> None:
        self.layers, self.steps, self.done = layers, steps, 0
        self.mean = [np.zeros_like(layer) for layer in layers]
        self.square = [np.zeros_like(layer) for layer in layers]

    def step(self, slope: list[AnyArray]) -> None:
        """Take one step."""
        self.done += 1
        rate = RATE * 0.5 * (1.0 + np.cos(np.pi * self.done / self.steps))
        one, two = (1.0 - memory**self.done for memory in MEMORY)
        for k, layer in enumerate(self.layers):
            self.mean[k] += (1.0 - MEMORY[0]) * (slope[k] - self.mean[k])
            self.square[k] += (1.0 - MEMORY[1]) * (slope[k] ** 2 - self.square[k])
            pace = (self.mean[k] / one) / (np.sqrt(self.square[k] / two) + TINY)
            layer -= (rate * (pace + DECAY * layer)).astype(np.float32)


def _store(about: str, names: tuple[str, ...], layers: list[AnyArray]) -> Stored:
    rounded = [np.array([f"{x:.{DIGITS}g}" for x in a.ravel()], float) for a in layers]
    shaped = [a.reshape(layer.shape).tolist() for a, layer in zip(rounded, layers, strict=True)]
    return Stored(
        about,
        names,
        tuple(tuple(map(tuple, weights)) for weights in shaped[::2]),
        tuple(map(tuple, shaped[1::2])),
    )
