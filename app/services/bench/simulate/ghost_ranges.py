"""Where a beam on two surfaces is reported, against the formulas of both kinds of ranging."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import (
    beam_row,
    greys,
    half_wall,
    send,
    silent,
    split_at_edge,
    wall_at,
)
from app.simulate.instrument import Instrument
from app.simulate.ranging import PhaseShift, Pulsed, phase_range, pulsed_ranges

GROUP = "ghosts"
NEAR = 2.0
GAPS = (0.02, 0.1, 0.24, 0.26, 0.4, 0.7, 1.0, 1.7, 3.0, 6.0)
"""Metres behind the first surface; 0.6 is half of the finest wavelength, 0.25 the blend."""
FRONT, BACK = (0.5, 0.3), (0.6, 0.4)
PULSES = Pulsed(0.15, 0.25, "first", 0.05)


def check_ghosts(quick: bool) -> list[Check]:
    """All checks of this file."""
    beams = 61 if quick else 301
    return [*_check_phase(beams), *_check_pulses(beams)]


def _received(instrument: Instrument, beams: int, gap: float) -> tuple[Floats, Floats, Floats]:
    """Distances and energies of all sub-rays, and the ranges that the scanner reports."""
    grid = beam_row(beams, 1.8e-3 / beams)
    walls = [half_wall(NEAR, greys(*FRONT)), wall_at(NEAR + gap, greys(*BACK))]
    front, distance, facing = split_at_edge(grid, instrument.bundle, NEAR, NEAR + gap)
    rho = np.where(front, FRONT[1], BACK[1])
    energy = instrument.bundle.subrays()[:, 2] * rho * facing / distance**2
    return distance, energy, send(walls, instrument, grid).distance


def _check_phase(beams: int) -> list[Check]:
    instrument = silent(PhaseShift())
    expected, found, place = [], [], []
    for gap in GAPS:
        distance, energy, reported = _received(instrument, beams, gap)
        ranges = [phase_range(d, e) for d, e in zip(distance, energy, strict=True)]
        expected.append(ranges)
        found.append(reported)
        place.append(
            np.where(
                reported < distance.min(axis=1) - 0.006,
                -1,
                np.where(reported > distance.max(axis=1) + 0.006, 1, 0),
            )
            * (np.ptp(distance, axis=1) > gap / 2)
        )
    where = np.concatenate(place)
    checks = [
        compare(
            GROUP,
            f"phase shift, surfaces {GAPS[0]:g} to {GAPS[-1]:g} m apart: the complex sum",
            expected,
            found,
            1e-7,
            "m",
        )
    ]
    for side, name in ((-1, "in front of"), (1, "behind")):
        some = float((where == side).any())
        checks.append(compare(GROUP, f"phase shift: ghosts {name} both surfaces occur", 1, some, 0))
    return checks


def _check_pulses(beams: int) -> list[Check]:
    instrument = silent(PULSES)
    expected: list[list[float]] = [[], []]
    found: list[list[float]] = [[], []]
    for gap in GAPS:
        distance, energy, reported = _received(instrument, beams, gap)
        apart = int(gap > PULSES.blend)
        first = [pulsed_ranges(d, e, PULSES)[0][0] for d, e in zip(distance, energy, strict=True)]
        expected[apart] += first
        found[apart] += reported.tolist()
    names = ("nearer than the blend: their weighted mean", "farther apart: the first with 5 %")
    return [
        compare(GROUP, f"pulsed, surfaces {name}", expected[k], found[k], 1e-7, "m")
        for k, name in enumerate(names)
    ]
