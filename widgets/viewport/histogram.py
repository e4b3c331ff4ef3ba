"""How the values of a field are spread, small enough to sit beside a colour bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats

BINS = 64
SAMPLE = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class Histogram:
    """Bars of a histogram.

    Attributes
    ----------
    edges : (bins + 1,) float64
    heights : (bins,) float64
        Shares of the highest bar, as square roots: small groups stay visible.
    """

    edges: Floats
    heights: Floats

    @classmethod
    def empty(cls) -> Histogram:
        """No values at all."""
        return cls(np.array([np.inf, -np.inf]), np.empty(0))

    @property
    def low(self) -> float:
        """Where the scale begins; infinity when it is empty."""
        return float(self.edges[0])

    @property
    def high(self) -> float:
        """Where the scale ends; minus infinity when it is empty."""
        return float(self.edges[-1])


def count_values(values: AnyArray, low: float, high: float) -> Histogram:
    """Count values between the 0.2 % and 99.8 % quantiles, or the limits if they reach further.

    Of large arrays every n-th value is enough for 64 bars.
    """
    sample = values[:: max(1, len(values) // SAMPLE)]
    sample = sample[np.isfinite(sample)].astype(np.float64)
    if len(sample) == 0:
        return Histogram.empty()
    first, last = np.quantile(sample, (0.002, 0.998))
    first, last = min(float(first), low), max(float(last), high)
    if not last > first:
        return Histogram.empty()
    counts, edges = np.histogram(sample, BINS, (first, last))
    return Histogram(edges, np.sqrt(counts / max(int(counts.max()), 1)))
