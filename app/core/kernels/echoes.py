"""From the crossings of a beam's sub-rays to energies, ranges and what was touched."""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER, SAFE

SMALL = 0.2
"""Radians up to which five terms of their series give sine and cosine to the last digit."""
FIRST, STRONGEST, LAST, ALL = 0, 1, 2, 3
COMPONENTS = 3
"""Surfaces of a return that are told apart, the one that sends back most first."""


class OpticsTable(NamedTuple):
    """Reflectance of every surface and channel."""

    rho: Any  # (surfaces, channels)
    curve: Any  # (surfaces, channels) row of `curves`
    curves: Any  # (c, samples): 1 at ω = 0, evenly spaced in √(1 − cos ω)


class BeamTable(NamedTuple):
    """Bundle of sub-rays and the way in which their echoes become ranges."""

    subrays: Any  # (3, k): offsets in units of the beam radius, share of the energy
    exit_radius: float  # m
    spread: float  # tan of the half divergence
    ranging_channel: int
    wavelengths: Any  # (w,) m, coarse to fine; none for a pulsed instrument
    octaves: Any  # (w,) how often each wavelength is half of the one before
    blend: float  # m: nearer echoes give one return
    least: float  # share of the energy that a return needs
    threshold: float  # reflectance × share that it needs
    most: int  # returns per beam
    pick: int
    pulse: float  # m, full width at half maximum
    sample: float  # m between samples of a waveform
    noise: float  # σ of a sample
    strength: Any  # (channels, s): echo of a white surface at 0, h, 2h …; none means 1 / d²
    lattice: float  # h, m


class EchoTable(NamedTuple):
    """Working memory of one thread: the sub-rays that met something, and the sums over them."""

    rays: Any  # (k,) which they are, near to far for a pulsed instrument
    energy: Any  # (k, channels) of each sub-ray
    total: Any  # (channels,)
    phasor: Any  # (2, w)
    touched: Any  # (k,) surfaces
    met: Any  # (k, 5): share, nearest and farthest distance, energy, energy × distance


@njit(**INNER)
def echo_strength(strength, lattice, c, t):  # type: ignore[no-untyped-def]
    """Echo of a white surface at a distance, by the instrument's range effect."""
    last = strength.shape[1] - 1
    if last < 0:
        return 1.0 / (t * t)
    place = min(t / lattice, last - 1e-9)
    i = int(place)
    return strength[c, i] + (place - i) * (strength[c, i + 1] - strength[c, i])


@njit(**INNER)
def collect(hits, beam, optics, echoes):  # type: ignore[no-untyped-def]
    """List the sub-rays that met something, with their energies; returns how many."""
    distance, facing, surface = hits.distance, hits.facing, hits.surface
    subrays, rho, curve, curves = beam.subrays, optics.rho, optics.curve, optics.curves
    rays, energy, total = echoes.rays, echoes.energy, echoes.total
    strength, lattice = beam.strength, beam.lattice
    count, last = 0, curves.shape[1] - 1
    total[:] = 0.0
    for k in range(len(distance)):
        if surface[k] < 0:
            continue
        rays[count] = k
        count += 1
        share = subrays[2, k]
        place = math.sqrt(max(1.0 - facing[k], 0.0)) * last
        i = min(int(place), last - 1)
        for c in range(len(total)):
            row = curve[surface[k], c]
            phase = curves[row, i] + (place - i) * (curves[row, i + 1] - curves[row, i])
            reach = echo_strength(strength, lattice, c, distance[k])
            energy[k, c] = share * rho[surface[k], c] * phase * reach
            total[c] += energy[k, c]
    return count


@njit(**INNER)
def sort_rays(rays, count, distance):  # type: ignore[no-untyped-def]
    """Put sub-rays in order of distance; they are nearly so already."""
    for i in range(1, count):
        ray = rays[i]
        j = i - 1
        while j >= 0 and distance[rays[j]] > distance[ray]:
            rays[j + 1] = rays[j]
            j -= 1
        rays[j + 1] = ray


@njit(**INNER, fastmath=SAFE)
def sum_fine_phase(rays, energy, distance, span, wave_number):  # type: ignore[no-untyped-def]
    """Phase of the summed echoes at one wavelength, all of them within `SMALL` of the first."""
    start, channel = distance[rays[0]], span[1]
    real, imaginary = 0.0, 0.0
    for i in range(span[0]):
        angle = wave_number * (distance[rays[i]] - start)
        s = angle * angle
        e = energy[rays[i], channel]
        real += e * (1.0 - s / 2 * (1.0 - s / 12 * (1.0 - s / 30 * (1.0 - s / 56))))
        imaginary += e * angle * (1.0 - s / 6 * (1.0 - s / 20 * (1.0 - s / 42 * (1.0 - s / 72))))
    return math.atan2(imaginary, real)


@njit(**INNER)
def unwrap(phasor, wavelengths):  # type: ignore[no-untyped-def]
    """Range from the phases of summed echoes: the coarse one picks the finer one's cycle."""
    distance = 0.0
    for w in range(len(wavelengths)):
        interval = 0.5 * wavelengths[w]
        turns = math.atan2(phasor[1, w], phasor[0, w]) / (2.0 * math.pi)
        distance = (turns + np.round(distance / interval - turns)) * interval
    return distance


@njit(**INNER)
def range_by_phase(hits, beam, echoes, count):  # type: ignore[no-untyped-def]
    """Range of a phase-shift scanner, folded into its unambiguous interval.

    Phases are taken against the first sub-ray's. Where all lie close together, the finest
    wavelength alone tells the range. Finer wavelengths divide coarser ones, so that their phasors
    are powers: one sine instead of many.
    """
    rays, energy, distance, phasor = echoes.rays, echoes.energy, hits.distance, echoes.phasor
    wavelengths, octaves, channel = beam.wavelengths, beam.octaves, beam.ranging_channel
    start, spread = distance[rays[0]], 0.0
    for i in range(count):
        spread = max(spread, abs(distance[rays[i]] - start))
    finest = 4.0 * math.pi / wavelengths[-1]
    if finest * spread < SMALL:
        angle = sum_fine_phase(rays, energy, distance, (count, channel), finest)
        return (start + angle / finest) % (0.5 * wavelengths[0])
    phasor[:] = 0.0
    for i in range(count):
        k = rays[i]
        e, angle = energy[k, channel], 4.0 * math.pi / wavelengths[0] * (distance[k] - start)
        re, im = math.cos(angle), math.sin(angle)
        phasor[0, 0] += e * re
        phasor[1, 0] += e * im
        for w in range(1, len(wavelengths)):
            for _ in range(octaves[w]):
                re, im = re * re - im * im, 2.0 * re * im
            phasor[0, w] += e * re
            phasor[1, w] += e * im
    return (start + unwrap(phasor, wavelengths)) % (0.5 * wavelengths[0])


@njit(**INNER)
def list_surfaces(hits, beam, echoes, span):  # type: ignore[no-untyped-def]
    """Surfaces met by the sub-rays `span` = (first, end) of the list; returns how many."""
    rays, touched, met, subrays = echoes.rays, echoes.touched, echoes.met, beam.subrays
    distance, surface, energy = hits.distance, hits.surface, echoes.energy
    channel = beam.ranging_channel
    found, slot = 0, 0
    for i in range(span[0], span[1]):
        k = rays[i]
        t, share, e = distance[k], subrays[2, k], energy[k, channel]
        if found == 0 or touched[slot] != surface[k]:
            slot = 0
            while slot < found and touched[slot] != surface[k]:
                slot += 1
        if slot == found:
            touched[slot] = surface[k]
            met[slot, 0], met[slot, 1], met[slot, 2] = 0.0, t, t
            met[slot, 3], met[slot, 4] = 0.0, 0.0
            found += 1
        met[slot, 0] += share
        met[slot, 1] = min(met[slot, 1], t)
        met[slot, 2] = max(met[slot, 2], t)
        met[slot, 3] += e
        met[slot, 4] += e * t
    return found


@njit(**INNER)
def sort_surfaces(echoes, found):  # type: ignore[no-untyped-def]
    """Put those that send back most first, as many as are told apart."""
    for i in range(min(found, COMPONENTS)):
        best = i
        for j in range(i + 1, found):
            if echoes.met[j, 3] > echoes.met[best, 3]:
                best = j
        if best != i:
            echoes.touched[i], echoes.touched[best] = echoes.touched[best], echoes.touched[i]
            for c in range(5):
                echoes.met[i, c], echoes.met[best, c] = echoes.met[best, c], echoes.met[i, c]


@njit(**INNER)
def distance_off(met, found, distance):  # type: ignore[no-untyped-def]
    """How far a range is from the nearest of the surfaces listed."""
    off = np.inf
    for i in range(found):
        off = min(off, max(met[i, 1] - distance, distance - met[i, 2], 0.0))
    return off


@njit(**INNER)
def split_returns(hits, beam, echoes, count, spans):  # type: ignore[no-untyped-def]
    """Spans of sub-rays that blend into one return each and are strong enough; how many."""
    c = beam.ranging_channel
    found, first, energy = 0, 0, 0.0
    for i in range(count):
        k = echoes.rays[i]
        energy += echoes.energy[k, c]
        ends = i + 1 == count
        if not ends:
            ends = hits.distance[echoes.rays[i + 1]] - hits.distance[k] >= beam.blend
        if ends:
            near = hits.distance[echoes.rays[first]]
            reach = echo_strength(beam.strength, beam.lattice, c, near)
            noticed = energy >= beam.threshold * reach
            if noticed and energy >= beam.least * echoes.total[c]:
                spans[found] = (float(first), float(i + 1), energy)
                found += 1
            first, energy = i + 1, 0.0
    return found


@njit(**INNER)
def pick_returns(beam, spans, found):  # type: ignore[no-untyped-def]
    """Leave in `spans` what the instrument reports, near to far; how many."""
    if found == 0:
        return 0
    if beam.pick == LAST:
        spans[0] = spans[found - 1]
    if beam.pick == STRONGEST:
        spans[0] = spans[np.argmax(spans[:found, 2])]
    if beam.pick != ALL:
        return 1
    while found > beam.most:
        weakest = np.argmin(spans[:found, 2])
        for i in range(weakest, found - 1):
            spans[i] = spans[i + 1]
        found -= 1
    return found


@njit(**INNER)
def blend_range(hits, beam, echoes, span):  # type: ignore[no-untyped-def]
    """Energy-weighted mean distance of a span of sub-rays; their energies into `total`."""
    echoes.total[:] = 0.0
    weighted = 0.0
    for i in range(int(span[0]), int(span[1])):
        k = echoes.rays[i]
        weighted += echoes.energy[k, beam.ranging_channel] * hits.distance[k]
        for c in range(len(echoes.total)):
            echoes.total[c] += echoes.energy[k, c]
    return weighted / echoes.total[beam.ranging_channel]
