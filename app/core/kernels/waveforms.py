"""The digitised return of a beam: pulses added up, noise, and the returns found in it."""

import math

from numba import njit

from app.core.kernels import INNER

LEAD = 2.0
"""The record begins this many pulse lengths before the first surface."""
NOISE_GATE = 4.0
"""A sample counts as a return from this many σ of the noise on."""


@njit(**INNER)
def digitise(hits, beam, echoes, count, wave):  # type: ignore[no-untyped-def]
    """Fill `wave` (channels, samples), noise in, waveform out; returns the first sample's range.

    A sample is in units of the reflectance of a full hit at the first surface's distance.
    """
    near = hits.distance[echoes.rays[0]]
    start = near - LEAD * beam.pulse
    narrow = 4.0 * math.log(2.0) / (beam.pulse * beam.pulse)
    wave *= beam.noise
    for i in range(count):
        k = echoes.rays[i]
        t = hits.distance[k]
        first = max(0, int((t - 2.5 * beam.pulse - start) / beam.sample))
        end = min(wave.shape[1], int((t + 2.5 * beam.pulse - start) / beam.sample) + 2)
        for s in range(first, end):
            x = start + s * beam.sample - t
            value = math.exp(-narrow * x * x) * near * near
            for c in range(wave.shape[0]):
                wave[c, s] += echoes.energy[k, c] * value
    return start


@njit(**INNER)
def find_pulses(beam, wave, spans):  # type: ignore[no-untyped-def]
    """Runs of samples above the threshold as (first, end, sum), near to far; how many."""
    c = beam.ranging_channel
    peak = 0.0
    for s in range(wave.shape[1]):
        peak = max(peak, wave[c, s])
    gate = max(NOISE_GATE * beam.noise, beam.least * peak)
    found, first, energy = 0, -1, 0.0
    for s in range(wave.shape[1] + 1):
        above = s < wave.shape[1] and wave[c, s] > gate
        if above:
            first = s if first < 0 else first
            energy += wave[c, s]
        elif first >= 0:
            if found < len(spans):
                spans[found] = (float(first), float(s), energy)
                found += 1
            first, energy = -1, 0.0
    return found


@njit(**INNER)
def measure_pulse(beam, wave, span, start, energies):  # type: ignore[no-untyped-def]
    """Range of a return by its centroid; its energies, by the sum method, into `energies`."""
    first, end = int(span[0]), int(span[1])
    weight, weighted = 0.0, 0.0
    for s in range(first, end):
        weight += wave[beam.ranging_channel, s]
        weighted += wave[beam.ranging_channel, s] * s
    area = beam.pulse * math.sqrt(math.pi / (4.0 * math.log(2.0)))
    for c in range(wave.shape[0]):
        energies[c] = 0.0
        for s in range(first, end):
            energies[c] += wave[c, s]
        energies[c] *= beam.sample / area
    return start + beam.sample * weighted / weight


@njit(**INNER)
def rays_within(hits, echoes, count, low, high):  # type: ignore[no-untyped-def]
    """Span of the sub-rays whose distance lies between two ranges."""
    first = 0
    while first < count and hits.distance[echoes.rays[first]] < low:
        first += 1
    end = first
    while end < count and hits.distance[echoes.rays[end]] <= high:
        end += 1
    return first, end
