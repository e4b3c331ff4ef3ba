"""The digitised return of a pulsed instrument, and the returns that are found in it."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np

from app.core.arrays import Floats
from app.core.errors import WrongUse
from app.simulate.limits import check_not_negative, check_positive

ABOVE_NOISE = 4.0
"""A sample counts as signal above this many σ of the noise."""
LEAD = 2.0
"""The record starts this many pulse lengths before the first echo."""
MOST_SAMPLES = 4096


@dataclass(frozen=True, slots=True)
class Waveform:
    """How a pulsed instrument digitises what comes back.

    Attributes
    ----------
    step : float
        Range between two samples, metres; 0.15 is one nanosecond.
    samples : int
        Length of the record, which starts just before the first echo; what lies behind its
        end is lost.
    noise : float
        σ of a sample, as the reflectance of a full hit.
    """

    step: float = 0.15
    samples: int = 128
    noise: float = 0.0

    def __post_init__(self) -> None:
        check_positive("The step between samples of a waveform", self.step)
        check_not_negative("The noise of a waveform", self.noise)
        if not 8 <= self.samples <= MOST_SAMPLES:
            raise WrongUse(
                f"A waveform cannot have {self.samples} samples.",
                f"Give a number from 8 to {MOST_SAMPLES}.",
            )


def sample_waveform(
    distances: Floats,
    energies: Floats,
    pulse: float,
    waveform: Waveform,
    noise: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Range and value of each sample, (samples,) both.

    Every echo is a Gaussian of `pulse` metres (full width at half maximum) whose peak is its
    energy.

    Parameters
    ----------
    distances, energies : (n,) arrays
        n ≥ 1.
    noise : (samples,) array, optional
        Standard normal numbers; the record is free of noise without them.
    """
    ranges = np.min(distances) - LEAD * pulse + waveform.step * np.arange(waveform.samples)
    away = (ranges[:, None] - np.asarray(distances, float)) / pulse
    values = np.exp(-4 * log(2) * away**2) @ np.asarray(energies, float)
    if noise is not None:
        values = values + waveform.noise * noise
    return ranges, values


def find_returns(
    ranges: Floats, values: Floats, pulse: float, least: float, waveform: Waveform
) -> tuple[Floats, Floats]:
    """Range and energy of the returns in a record, in order of range.

    A return is a run of samples above both `ABOVE_NOISE` σ and the share `least` of the highest
    one. Its range is the centroid of what rises over that gate, its energy the sum of the samples
    (science 1.4: the sum method), as the reflectance of a full hit; what the pulse's feet hold
    below the gate is missing from it.
    """
    gate = max(ABOVE_NOISE * waveform.noise, least * float(values.max()))
    above = np.concatenate([[False], values > gate, [False]])
    edges = np.flatnonzero(above[1:] != above[:-1]).reshape(-1, 2)
    runs = [slice(first, end) for first, end in edges]
    sums = np.array([values[run].sum() for run in runs])
    over = values - gate
    centroids = np.array([over[run] @ ranges[run] / over[run].sum() for run in runs])
    # The sum of a Gaussian's samples is its area over the step.
    return centroids, sums * waveform.step / (pulse * sqrt(pi / (4 * log(2))))
