"""The energy of a return in a digitised waveform: sum, peak and Gaussian, each with its σ.

The return is the run of samples around its place that lie above the threshold: background plus
some σ of the noise. Where the record falls inside that run and rises again by more than the
same number of σ of a difference (√2 as much), another return begins; each gets half of the sample
in the valley.

- The sum method (Hancock et al. 2017) adds the samples up. What the feet of the pulse hold
  below the threshold is missing: the share erfc √ln(height / threshold) of a Gaussian.
- The peak is the highest sample, refined by a parabola through the logarithms of three.
- The Gaussian is fitted to the samples and two more at each side, saturated ones left out.

The σ come from the noise of the samples, taken to be independent from one to the next, and from
that of the background. That of the sum also knows the samples at its feet that noise, or the
place of the samples on the pulse, moves over the threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.errors import WrongUse
from app.core.progress import QUIET, Progress

SIGMAS = 5.0
"""Noise passes 5 σ in one of 3 million samples: hardly once in 10 000 records of 256.
At 3 σ every third record would hold a false return; more than 5 only costs weak returns."""
NO_SIGNAL, MERGED, CUT_OFF, SATURATED, NO_FIT = 1, 2, 4, 8, 16
"""Bits of `Returns.marks`: nothing above the threshold near the place; overlaps with another
return; reaches the first or last sample; has saturated samples; no Gaussian fits."""

MEASURED = (
    "level", "noise", "sum", "peak", "gaussian", "sum_sigma", "peak_sigma", "gaussian_sigma",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Returns:
    """What the samples of each return tell, (k,) each.

    Attributes
    ----------
    level, noise : float64
        Background, and σ of a sample; in the unit of the samples.
    sum, sum_sigma : float64
        Samples over the background added up, times the step; a lower limit if saturated.
    peak, peak_sigma : float64
        Height over the background.
    gaussian, gaussian_sigma : float64
        Area under the fitted Gaussian, in the unit of `sum`.
    marks : uint8
        Bits of `NO_SIGNAL`, `MERGED`, `CUT_OFF`, `SATURATED`, `NO_FIT`.
    saturated : int32
        Number of saturated samples.
    """

    level: Floats
    noise: Floats
    sum: Floats
    peak: Floats
    gaussian: Floats
    sum_sigma: Floats
    peak_sigma: Floats
    gaussian_sigma: Floats
    marks: AnyArray
    saturated: AnyArray


def measure_returns(
    samples: Floats, offsets: Ints, place: Floats, step: Floats | float = 1.0,
    sigmas: float = SIGMAS, quantum: Floats | float = 0.0, ceiling: Floats | float = np.inf,
    level: Floats | float = np.nan, noise: Floats | float = np.nan, progress: Progress = QUIET,
) -> Returns:  # fmt: skip
    """Measure the return at a place in each of many waveforms; see the head of this module.

    Parameters
    ----------
    samples : (m,) array
        The waveforms one after the other.
    offsets : (k + 1,) array
        Waveform i is ``samples[offsets[i]:offsets[i + 1]]``; waveforms may be empty.
    place : (k,) array
        Where the return is, in samples from the first; looked for within three samples.
    step : (k,) array or float
        Time between samples, in whatever unit the energies shall have.
    sigmas : float
        σ of the noise from the background to the threshold.
    quantum : (k,) array or float
        Step of the digitiser; the noise is at least quantum / √12.
    ceiling : (k,) array or float
        Samples from here on are saturated.
    level, noise : (k,) array or float
        Background and σ where they are known; NaN: found in each waveform. Median and median
        absolute deviation start; then mean and deviation of the samples that are within 3.5 σ,
        and not within two samples of one that is not.

    Raises
    ------
    WrongUse
        Lengths do not fit, or `sigmas` is not positive.
    Cancelled
    """
    from app.core.kernels import returns as kernel

    offsets, count = _check(samples, offsets, place, sigmas)
    each = (np.broadcast_to(a, count) for a in (place, quantum, ceiling, level, noise))
    records = kernel.Records(
        np.ascontiguousarray(samples, np.float64),
        offsets,
        *(np.ascontiguousarray(a, np.float64) for a in each),
    )
    room = kernel.Room(np.empty((count, 8)), np.zeros(count, np.uint8), np.zeros(count, np.int32))
    longest = int(np.diff(offsets).max(initial=0))

    def work(first: int, last: int) -> None:
        kernel.measure_records(records, sigmas, first, last, np.empty(longest), room)

    run_in_pieces(work, split_evenly(count, 2000), progress, "Measuring returns")
    columns = np.ascontiguousarray(room.found.T)
    for row in (kernel.SUM, kernel.AREA, kernel.SUM_SIGMA, kernel.AREA_SIGMA):
        columns[row] *= step
    energies = dict(zip(MEASURED, columns, strict=True))
    return Returns(**energies, marks=room.marks, saturated=room.clipped)


def _check(samples: Floats, offsets: Ints, place: Floats, sigmas: float) -> tuple[Ints, int]:
    whole = np.ascontiguousarray(offsets, np.int64)
    if not (np.isfinite(sigmas) and sigmas > 0.0):
        raise WrongUse(f"The threshold of a waveform must be some σ above 0, not {sigmas}.")
    rising = len(whole) > 0 and whole[0] >= 0 and bool(np.all(np.diff(whole) >= 0))
    if not rising or whole[-1] > len(samples) or len(place) != len(whole) - 1:
        raise WrongUse("Waveforms need rising offsets within their samples, and a place each.")
    return whole, len(place)
