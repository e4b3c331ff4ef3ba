"""One return in a digitised record: its samples, what they add up to, and how sure that is."""

import math
from typing import Any, NamedTuple

from numba import njit

from app.core.kernels import INNER
from app.core.kernels.gaussian_pulse import fit_gaussian
from app.core.kernels.record_noise import FEET, find_noise
from app.core.kernels.waveforms import vary_above

LEVEL, NOISE, SUM, PEAK, AREA, SUM_SIGMA, PEAK_SIGMA, AREA_SIGMA = range(8)
"""Columns of what is measured."""
NO_SIGNAL, MERGED, CUT_OFF, SATURATED, NO_FIT = 1, 2, 4, 8, 16
"""Bits of the marks."""
NEAR = 3
"""Samples from the place that the file names within which the return is looked for."""
CLEAR = 3.0
"""σ over the background from which on a sample has a useful logarithm."""
FAR = 6.0
"""σ from the threshold beyond which chance does not decide whether a sample counts."""


class Records(NamedTuple):
    """Waveforms one after the other, and where in each the return is."""

    samples: Any  # (m,) volts
    offsets: Any  # (k + 1,)
    place: Any  # (k,) samples from the first
    quantum: Any  # (k,) volts
    ceiling: Any  # (k,) volts
    level: Any  # (k,) volts; NaN: find it
    noise: Any  # (k,) volts; NaN: find it


class Room(NamedTuple):
    """Where the results go."""

    found: Any  # (k, 8)
    marks: Any  # (k,) uint8
    clipped: Any  # (k,) int32


@njit(cache=True, nogil=True, error_model="numpy")
def measure_records(records, sigmas, first, last, scratch, room):  # type: ignore[no-untyped-def]
    """Measure the returns from `first` to before `last`; see `radiometry.waveform`."""
    samples, offsets, place = records.samples, records.offsets, records.place
    quantum, ceiling = records.quantum, records.ceiling
    level, noise = records.level, records.noise
    found, marks, clipped = room.found, room.marks, room.clipped
    for k in range(first, last):
        span = (offsets[k], offsets[k + 1])
        quiet = find_noise(samples, span, quantum[k], scratch)
        if not math.isnan(level[k]):
            quiet = (level[k], quiet[1], 0.0, quiet[3])
        if not math.isnan(noise[k]):
            quiet = (quiet[0], noise[k], quiet[2], 0.0)
        found[k, LEVEL], found[k, NOISE] = quiet[0], quiet[1]
        gate = quiet[0] + sigmas * quiet[1]
        at = find_return(samples, span, place[k], gate)
        if at < 0:
            marks[k] = NO_SIGNAL
            for c in range(SUM, AREA_SIGMA + 1):
                found[k, c] = math.nan
            continue
        bounds = bound_return(samples, span, at, gate, math.sqrt(2.0) * (gate - quiet[0]))
        marks[k], clipped[k] = mark_return(samples, span, bounds, ceiling[k])
        found[k, SUM], found[k, SUM_SIGMA] = sum_return(samples, span, bounds, gate, quiet)
        found[k, PEAK], found[k, PEAK_SIGMA] = find_peak(samples, span, bounds, quiet)
        feet = reach_feet(samples, span, bounds, gate)
        area, sigma = fit_gaussian(samples, bounds, feet, quiet, ceiling[k])
        found[k, AREA], found[k, AREA_SIGMA] = area, sigma
        if math.isnan(area):
            marks[k] |= NO_FIT


@njit(**INNER)
def find_return(samples, span, place, gate):  # type: ignore[no-untyped-def]
    """The sample above the gate nearest to the place; −1 where there is none near."""
    first, end = span
    if not -NEAR - 1.0 < place < end - first + NEAR:
        return -1
    middle = first + math.floor(place + 0.5)
    for away in range(NEAR + 1):
        for i in (middle + away, middle - away):
            if first <= i < end and samples[i] > gate:
                return i
    return -1


@njit(**INNER)
def bound_return(samples, span, at, gate, rise):  # type: ignore[no-untyped-def]
    """First and end of the return, and which ends (1: low, 2: high) are valleys to another one.

    A return ends at the gate, or at a valley that the record rises from by more than `rise`.
    A valley belongs to both of its returns.
    """
    first, end = span
    low, high = at, at + 1
    while low > first and samples[low - 1] > gate:
        low -= 1
    while high < end and samples[high] > gate:
        high += 1
    top, bottom, rising, ends = low, low, True, 0
    for i in range(low, high):
        if rising:
            if samples[i] > samples[top]:
                top = i
            elif samples[top] - samples[i] > rise:
                rising, bottom = False, i
        elif samples[i] < samples[bottom]:
            bottom = i
        elif samples[i] - samples[bottom] > rise:
            if at < bottom:
                return low, bottom + 1, ends | 2
            low, top, rising, ends = bottom, i, True, 1
    return low, high, ends


@njit(**INNER)
def mark_return(samples, span, bounds, ceiling):  # type: ignore[no-untyped-def]
    """Bits of what is not as it should be, and the number of saturated samples."""
    low, high, ends = bounds
    mark, clipped = 0, 0
    for i in range(low, high):
        if samples[i] >= ceiling:
            clipped += 1
    if ends:
        mark |= MERGED
    if low == span[0] or high == span[1]:
        mark |= CUT_OFF
    if clipped:
        mark |= SATURATED
    return mark, clipped


@njit(**INNER)
def sum_return(samples, span, bounds, gate, quiet):  # type: ignore[no-untyped-def]
    """Sum of the samples over the background, and its σ.

    At a valley half of the sample counts. Noise decides whether a sample at the foot counts;
    the variance of that is taken at the value seen, in place of the unknown one without noise.
    """
    low, high, ends = bounds
    level, sigma = quiet[0], quiet[1]
    total, weight, variance, top = 0.0, 0.0, 0.0, gate
    for i in range(low, high):
        valley = (ends & 1 and i == low) or (ends & 2 and i == high - 1)
        share = 0.5 if valley else 1.0
        total += share * (samples[i] - level)
        weight += share
        top = max(top, samples[i])
        certain = valley or samples[i] - gate > FAR * sigma
        own = sigma * sigma if certain else vary_above(samples[i] - level, gate - level, sigma)[0]
        variance += share * share * own
    for i in range(max(low - FEET, span[0]), min(high + FEET, span[1])):
        beside = (i < low and not ends & 1) or (i >= high and not ends & 2)
        if beside and 0.0 <= gate - samples[i] < FAR * sigma:
            variance += vary_above(samples[i] - level, gate - level, sigma)[0]
    free = (0 if ends & 1 or low == span[0] else 1) + (0 if ends & 2 or high == span[1] else 1)
    return total, math.sqrt(variance + vary_edges(gate, top, weight, free, quiet))


@njit(**INNER)
def vary_edges(gate, top, weight, free, quiet):  # type: ignore[no-untyped-def]
    """Variance of a sum by an unsure background and threshold, and by where samples fall.

    A Gaussian of height H stands over the threshold T for `weight` samples; at its edges it
    needs weight / (4 ln (H / T)) samples to rise by T. Where the samples fall on these edges is
    chance: T² Σ exp(−(2πkq)²) / (2π²k²) for each, noise blurring the edge by q samples.
    """
    level, sigma, error, unsure = quiet
    height = gate - level
    if height <= 0.0:
        return 0.0
    reach = weight / (4.0 * max(math.log((top - level) / height), 0.25))
    q = reach * sigma / height
    phase = 0.0
    for k in range(1, 9):
        phase += math.exp(-((2.0 * math.pi * k * q) ** 2)) / (2.0 * math.pi**2 * k**2)
    lost = free * reach
    return (
        free * height * height * phase
        + ((weight + lost) * error) ** 2
        + (lost * height / sigma * unsure) ** 2
    )


@njit(**INNER)
def find_peak(samples, span, bounds, quiet):  # type: ignore[no-untyped-def]
    """Height of the highest sample over the background, refined by its neighbours, and its σ.

    The parabola goes through the logarithms, which is exact for a Gaussian pulse; through the
    samples themselves where a neighbour is so low that its logarithm is mostly noise.
    """
    low, high, _ = bounds
    level, sigma, error = quiet[0], quiet[1], quiet[2]
    top = low
    for i in range(low, high):
        top = i if samples[i] > samples[top] else top
    height = samples[top] - level
    if top == span[0] or top == span[1] - 1:
        return height, math.hypot(sigma, error)
    before, after = samples[top - 1] - level, samples[top + 1] - level
    logs = min(before, after) > CLEAR * sigma
    down = math.log(before / height) if logs else before - height
    up = math.log(after / height) if logs else after - height
    if up + down >= 0.0:  # level top, as of a saturated return
        return height, math.hypot(sigma, error)
    x = 0.5 * (down - up) / (up + down)
    rise = -0.125 * (up - down) ** 2 / (up + down)
    a, b, c = 0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)
    peak = height + rise
    if logs:
        peak = height * math.exp(rise)
        a, b, c = a * peak / before, b * peak / height, c * peak / after
    spread = sigma * math.sqrt(a * a + b * b + c * c)
    return peak, math.hypot(spread, (a + b + c) * error)


@njit(**INNER)
def reach_feet(samples, span, bounds, gate):  # type: ignore[no-untyped-def]
    """The return with the samples of its feet, as far as they are no other return's."""
    low, high, ends = bounds
    start, stop = low, high
    while not ends & 1 and start > max(low - FEET, span[0]) and samples[start - 1] <= gate:
        start -= 1
    while not ends & 2 and stop < min(high + FEET, span[1]) and samples[stop] <= gate:
        stop += 1
    return start, stop
