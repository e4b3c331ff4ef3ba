"""The digitised return of a beam: pulses added up, noise, and the returns found in it."""

import math

from numba import njit

from app.core.kernels import INNER
from app.core.kernels.echoes import echo_strength

LEAD = 2.0
"""The record begins this many pulse lengths before the first surface."""
FEET = 2
"""Samples beside a return that noise may lift over its gate."""
NOISE_GATE = 4.0
"""A sample counts as a return from this many σ of the noise on."""


@njit(**INNER)
def digitise(hits, beam, echoes, count, clean, noisy):  # type: ignore[no-untyped-def]
    """Fill `clean` (channels, samples) and add it to the noise in `noisy`; the first range.

    A sample is in units of the reflectance of a full hit at the first surface's distance.
    """
    near = hits.distance[echoes.rays[0]]
    start = near - LEAD * beam.pulse
    narrow = 4.0 * math.log(2.0) / (beam.pulse * beam.pulse)
    clean[:, :] = 0.0
    for i in range(count):
        k = echoes.rays[i]
        t = hits.distance[k]
        first = max(0, int((t - 2.5 * beam.pulse - start) / beam.sample))
        end = min(clean.shape[1], int((t + 2.5 * beam.pulse - start) / beam.sample) + 2)
        for s in range(first, end):
            x = start + s * beam.sample - t
            value = math.exp(-narrow * x * x)
            for c in range(clean.shape[0]):
                reach = echo_strength(beam.strength, beam.lattice, c, near)
                clean[c, s] += echoes.energy[k, c] * value / reach
    for c in range(clean.shape[0]):
        for s in range(clean.shape[1]):
            noisy[c, s] = clean[c, s] + beam.noise * noisy[c, s]
    return start


@njit(**INNER)
def foresee_noise(beam, clean, span, gate):  # type: ignore[no-untyped-def]
    """σ of a return's range, of its energy in the ranging channel and in another one."""
    first, end = int(span[0]), int(span[1])
    weight, weighted, square = 0.0, 0.0, 0.0
    for s in range(first, end):
        height = clean[beam.ranging_channel, s] - gate
        weight += height
        weighted += height * s
    for s in range(first, end):
        square += (s - weighted / weight) ** 2
    of_range = beam.noise * beam.sample * math.sqrt(square) / weight
    own, other = 0.0, 0.0
    for s in range(max(first - FEET, 0), min(end + FEET, clean.shape[1])):
        a, b = vary_above(clean[beam.ranging_channel, s], gate, beam.noise)
        own += a
        other += b
    scale = beam.sample / (beam.pulse * math.sqrt(math.pi / (4.0 * math.log(2.0))))
    return of_range, math.sqrt(own) * scale, math.sqrt(other) * scale


@njit(**INNER)
def vary_above(value, gate, noise):  # type: ignore[no-untyped-def]
    """Variance of a noisy sample that counts as 0 below the gate, and of one beside it.

    The one beside is another channel's: it counts when the first does, with noise of its own.
    """
    if noise == 0.0:
        return 0.0, 0.0
    a = (gate - value) / noise
    share = 0.5 * math.erfc(a / math.sqrt(2.0))
    density = math.exp(-0.5 * a * a) / math.sqrt(2.0 * math.pi)
    mean = value * share + noise * density
    square = (value * value + noise * noise) * share + noise * (value + gate) * density
    beside = share * noise * noise + value * value * share * (1.0 - share)
    return square - mean * mean, beside


@njit(**INNER)
def find_gate(beam, wave):  # type: ignore[no-untyped-def]
    """Height from which a sample of the ranging channel belongs to a return."""
    peak = 0.0
    for s in range(wave.shape[1]):
        peak = max(peak, wave[beam.ranging_channel, s])
    return max(NOISE_GATE * beam.noise, beam.least * peak)


@njit(**INNER)
def find_pulses(beam, wave, gate, spans):  # type: ignore[no-untyped-def]
    """Runs of samples above the gate as (first, end, sum), near to far; how many."""
    c = beam.ranging_channel
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
def find_clean(beam, clean, span):  # type: ignore[no-untyped-def]
    """The samples that a return would have without noise, around its highest, and their gate."""
    wave = clean[beam.ranging_channel]
    top = int(span[0])
    for s in range(int(span[0]), int(span[1])):
        top = s if wave[s] > wave[top] else top
    gate = min(find_gate(beam, clean), 0.5 * wave[top])
    first, end = top, top + 1
    while first > 0 and wave[first - 1] > gate:
        first -= 1
    while end < len(wave) and wave[end] > gate:
        end += 1
    return (float(first), float(end)), gate


@njit(**INNER)
def measure_pulse(beam, wave, span, gate, start, near, energies):  # type: ignore[no-untyped-def]
    """Range of a return by its centroid over the gate; energies, summed up, into `energies`.

    What rises over the gate weighs: a sample at the foot that is just in or out changes nothing.
    """
    first, end = int(span[0]), int(span[1])
    weight, weighted = 0.0, 0.0
    for s in range(first, end):
        height = max(wave[beam.ranging_channel, s] - gate, 0.0)
        weight += height
        weighted += height * s
    area = beam.pulse * math.sqrt(math.pi / (4.0 * math.log(2.0)))
    for c in range(wave.shape[0]):
        energies[c] = 0.0
        for s in range(first, end):
            energies[c] += wave[c, s]
        energies[c] *= beam.sample / area * echo_strength(beam.strength, beam.lattice, c, near)
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
