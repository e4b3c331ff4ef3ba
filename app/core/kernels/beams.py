"""The virtual scanner's loop: every beam of a band of the grid, and what comes back."""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from app.core.kernels import INNER
from app.core.kernels.boxes import DEEPEST, meet_tree
from app.core.kernels.echoes import (
    COMPONENTS,
    EchoTable,
    blend_range,
    collect,
    distance_off,
    echo_strength,
    list_surfaces,
    pick_returns,
    range_by_phase,
    sort_rays,
    sort_surfaces,
    split_returns,
)
from app.core.kernels.rays import HitTable, split
from app.core.kernels.surfaces import face_normal
from app.core.kernels.vectors import cross, dot
from app.core.kernels.waveforms import (
    digitise,
    find_clean,
    find_gate,
    find_pulses,
    foresee_noise,
    measure_pulse,
    rays_within,
)

ZERO = np.int64(0)
"""A bare 0 would have every function that gets it compiled once more, for this very number."""


# Columns of `ReturnTable.values` and `labels`: two arrays are handed on faster than ten.
DISTANCE, OFF, SHIFT, OMEGA, NORMAL, SHARE, WANDER, ENERGY = 0, 1, 2, 3, 4, 7, 10, 14
CELL, SURFACE, TOUCHED, WAVE = 0, 1, 4, 5


class ReturnTable(NamedTuple):
    """Room for the returns of a band, one row each; −1 and 0 where a component is missing."""

    values: Any  # (m, 14 + channels): noise-free range, off every surface, shift, ω; normal;
    # shares of the components; of a waveform what its noise did to the range, σ of that, of an
    # energy in the ranging channel and in another; energies as reflectance × share, free of noise;
    # of a waveform again, with noise
    labels: Any  # (m, 6) int64: cell, surfaces of the components, how many there are, waveform
    wave: Any  # (w, channels, samples); no rows where waveforms are not kept
    wave_start: Any  # (w,) range of the first sample


@njit(**INNER)
def point_beam(origin, elevation, azimuth):  # type: ignore[no-untyped-def]
    """Axes of a beam: origin, direction, and the two directions across it (left, up)."""
    ce, se = math.cos(elevation), math.sin(elevation)
    ca, sa = math.cos(azimuth), math.sin(azimuth)
    o = (origin[0], origin[1], origin[2])
    return o, (ce * ca, ce * sa, se), (-sa, ca, 0.0), (-se * ca, -se * sa, ce)


@njit(**INNER)
def central_ray(hits, echoes, span, surface):  # type: ignore[no-untyped-def]
    """The sub-ray nearest to the beam's centre that met a surface."""
    best = len(hits.distance)
    for i in range(span[0], span[1]):
        k = echoes.rays[i]
        if hits.surface[k] == surface and k < best:
            best = k
    return best


@njit(**INNER)
def write_return(out, m, table, beam, ray, hits, echoes, span, distance):  # type: ignore[no-untyped-def]
    """Row m of the table: the return made of a span of sub-rays, reported at `distance`."""
    axes, column, count = ray
    met, touched, subrays = echoes.met, echoes.touched, beam.subrays
    values, labels = out.values, out.labels
    found = list_surfaces(hits, beam, echoes, (ZERO, count))
    off = distance_off(met, found, distance)
    if span[1] - span[0] < count:
        found = list_surfaces(hits, beam, echoes, span)
    sort_surfaces(echoes, found)
    for i in range(COMPONENTS):
        labels[m, SURFACE + i] = touched[i] if i < found else -1
        values[m, SHARE + i] = met[i, 0] if i < found else 0.0
    labels[m, TOUCHED] = found
    k = central_ray(hits, echoes, span, touched[0])
    o, d = split(axes, (beam.exit_radius, beam.spread), subrays[0, k], subrays[1, k])
    n = face_normal(table, touched[0], column, (o, d, hits.distance[k]))
    values[m, NORMAL], values[m, NORMAL + 1], values[m, NORMAL + 2] = n
    # arccos would lose half of the digits near 0°.
    across = cross(n, d)
    values[m, OMEGA] = math.atan2(math.sqrt(dot(across, across)), abs(dot(n, d)))
    values[m, DISTANCE], values[m, OFF] = distance, off
    values[m, SHIFT] = distance - met[0, 4] / met[0, 3]


@njit(**INNER)
def write_energy(out, m, place, beam, total, distance):  # type: ignore[no-untyped-def]
    """Energies into columns of row m, as a calibrated instrument would report them at a range."""
    values = out.values
    for c in range(len(total)):
        values[m, place + c] = total[c] / echo_strength(beam.strength, beam.lattice, c, distance)


@njit(**INNER)
def write_phase(out, m, table, beam, ray, hits, echoes):  # type: ignore[no-untyped-def]
    """The one return of a phase-shift scanner; returns the next free row."""
    count = ray[2]
    distance = range_by_phase(hits, beam, echoes, count)
    if not distance > 0.0:
        return m
    write_energy(out, m, ENERGY, beam, echoes.total, distance)
    write_return(out, m, table, beam, ray, hits, echoes, (ZERO, count), distance)
    return m + 1


@njit(**INNER)
def write_pulses(out, m, table, beam, ray, hits, echoes, spans):  # type: ignore[no-untyped-def]
    """The returns of a pulsed scanner, blended in groups; returns the next free row."""
    found = pick_returns(beam, spans, split_returns(hits, beam, echoes, ray[2], spans))
    for i in range(found):
        distance = blend_range(hits, beam, echoes, spans[i])
        write_energy(out, m, ENERGY, beam, echoes.total, distance)
        span = (int(spans[i, 0]), int(spans[i, 1]))
        write_return(out, m, table, beam, ray, hits, echoes, span, distance)
        m += 1
    return m


@njit(**INNER)
def write_waveform(out, m, table, beam, ray, hits, echoes, spans, waves):  # type: ignore[no-untyped-def]
    """The returns found in a digitised, noisy waveform; the next free row, and its start.

    `waves` are the clean one, to be filled, and the noise, to which it is added. Returns are
    found in the noisy one; the truth is what the clean one says of them.
    """
    count, (clean, noisy) = ray[2], waves
    start = digitise(hits, beam, echoes, count, clean, noisy)
    near = hits.distance[echoes.rays[0]]
    gate = find_gate(beam, noisy)
    found = pick_returns(beam, spans, find_pulses(beam, noisy, gate, spans))
    channels, values = len(echoes.total), out.values
    for i in range(found):
        low = start + (spans[i, 0] - 1) * beam.sample
        high = start + spans[i, 1] * beam.sample
        span = rays_within(hits, echoes, count, low, high)
        if span[0] == span[1]:
            continue
        reported = measure_pulse(beam, noisy, spans[i], gate, start, near, echoes.total)
        write_energy(out, m, ENERGY + channels, beam, echoes.total, reported)
        quiet, low = find_clean(beam, clean, spans[i])
        distance = measure_pulse(beam, clean, quiet, low, start, near, echoes.total)
        write_energy(out, m, ENERGY, beam, echoes.total, distance)
        values[m, WANDER] = reported - distance
        foreseen = foresee_noise(beam, clean, quiet, low)
        for k in range(3):
            values[m, WANDER + 1 + k] = foreseen[k]
        write_return(out, m, table, beam, ray, hits, echoes, span, distance)
        m += 1
    return m, start


@njit(cache=True, nogil=True, error_model="numpy")
def trace(table, tree, optics, beam, origin, elevation, azimuth, band, noise, out):  # type: ignore[no-untyped-def]
    """Trace the rows `band` = (first, end) of a grid into `out`; how many returns, waveforms.

    `noise` is (beams of the band, channels, samples) of unit variance for an instrument that
    digitises, and has no rows for any other. Threads take a band each: numba's own parallel
    loop cannot carry nested tables.
    """
    columns, rays, channels = len(azimuth), beam.subrays.shape[1], optics.rho.shape[1]
    hits = HitTable(np.empty(rays), np.empty(rays), np.empty(rays, np.int64), np.empty((2, rays)))
    echoes = EchoTable(
        np.empty(rays, np.int64),
        np.empty((rays, channels)),
        np.empty(channels),
        np.empty((2, len(beam.wavelengths))),
        np.empty(rays, np.int64),
        np.empty((rays, 5)),
    )
    spans = np.empty((rays, 3))
    clean = np.empty((noise.shape[1], noise.shape[2]), np.float32)
    stack, entry = np.empty(DEEPEST, np.int64), np.empty(DEEPEST)
    pulsed, digitises = len(beam.wavelengths) == 0, len(noise) > 0
    m, waves = ZERO, ZERO
    for row in range(band[0], band[1]):
        for column in range(columns):
            axes = point_beam(origin, elevation[row], azimuth[column])
            meet_tree(table, tree, column, axes, beam, hits, stack, entry)
            count = collect(hits, beam, optics, echoes)
            if count == 0 or echoes.total[beam.ranging_channel] <= 0.0:
                continue
            ray, first = (axes, column, count), m
            if not pulsed:
                m = write_phase(out, m, table, beam, ray, hits, echoes)
            else:
                sort_rays(echoes.rays, count, hits.distance)
                if digitises:
                    wave = noise[(row - band[0]) * columns + column]
                    waveforms = (clean, wave)
                    m, start = write_waveform(
                        out, m, table, beam, ray, hits, echoes, spans, waveforms
                    )
                    if m > first and len(out.wave) > 0:
                        out.wave[waves] = wave
                        out.wave_start[waves] = start
                        for i in range(first, m):
                            out.labels[i, WAVE] = waves
                        waves += 1
                else:
                    m = write_pulses(out, m, table, beam, ray, hits, echoes, spans)
            for i in range(first, m):
                out.labels[i, CELL] = row * columns + column
    return m, waves
