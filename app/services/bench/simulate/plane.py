"""A plane at every angle of incidence, against the closed form."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.core.units import to_degrees, to_radians
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import (
    LEAF,
    THIN,
    greys,
    send,
    silent,
    single_beam,
    subrays_of,
    wall_at,
)
from app.simulate.instrument import Instrument
from app.simulate.material import Material
from app.simulate.ranging import PhaseShift, phase_range
from app.simulate.scanner import Echoes

GROUP = "plane"
AWAY = 3.0
MATT = greys(0.6, 0.4)


def check_plane(quick: bool) -> list[Check]:
    """Thin beams to the last digit; beams of 37 sub-rays against the same sum in numpy."""
    angles = np.arange(0.0, 90.0, 10.0 if quick else 1.0)
    found: list[Check] = []
    for name, material, phase in (
        ("Lambertian plane", MATT, _lambert),
        ("Lambert–Beckmann plane", LEAF, _lambert_beckmann),
    ):
        found += _check_thin(name, material, phase(to_radians(angles)), angles)
        found += _check_bundle(name, material, angles)
    return found


def _lambert(omega: Floats) -> Floats:
    return np.outer(np.cos(omega), [0.6, 0.4])


def _lambert_beckmann(omega: Floats) -> Floats:
    """Science, section 3, with the parameters of `rig.LEAF`."""
    columns = []
    for rho, k_d, m in ((0.48, 0.88, 0.22), (0.27, 0.72, 0.30)):
        gloss = np.exp(-(np.tan(omega) ** 2) / m**2) / np.cos(omega) ** 5
        columns.append(rho * (k_d * np.cos(omega) + (1 - k_d) * gloss))
    return np.stack(columns, axis=1)


def _scan(angles: Floats, material: Material, instrument: Instrument) -> list[Echoes]:
    return [send([wall_at(AWAY, material, angle)], instrument) for angle in angles]


def _check_thin(name: str, material: Material, expected: Floats, angles: Floats) -> list[Check]:
    echoes = _scan(angles, material, silent(bundle=THIN))
    energy = np.concatenate([echo.energy for echo in echoes])
    omega = to_degrees(np.concatenate([echo.incidence for echo in echoes]))
    distance = np.concatenate([echo.distance for echo in echoes])
    what = f"{name}, 0 to {angles[-1]:.0f}°, thin beam:"
    # Phase functions are tabulated, and linear between their samples.
    return [
        compare(GROUP, f"{what} intensity", expected, energy, 2e-6, "reflectance"),
        compare(GROUP, f"{what} incidence", angles, omega, 1e-9, "°"),
        compare(GROUP, f"{what} range", np.full(len(angles), AWAY), distance, 1e-9, "m"),
    ]


def _check_bundle(name: str, material: Material, angles: Floats) -> list[Check]:
    instrument = silent(PhaseShift())
    echoes = _scan(angles, material, instrument)
    start, direction, share = (
        part.squeeze() for part in subrays_of(single_beam(), instrument.bundle)
    )
    phase = _lambert if material is MATT else _lambert_beckmann
    ranges, energies = [], []
    for tilt in to_radians(angles):
        normal = np.array([np.cos(tilt), np.sin(tilt), 0.0])
        away = (AWAY * np.cos(tilt) - start @ normal) / (direction @ normal)
        facing = direction @ normal / np.linalg.norm(direction, axis=1)
        echo = share[:, None] * phase(np.arccos(facing)) / away[:, None] ** 2
        channel = instrument.ranging_channel
        ranges.append(phase_range(away, echo[:, channel]))
        energies.append(echo.sum(axis=0) * ranges[-1] ** 2)
    what = f"{name}, 0 to {angles[-1]:.0f}°, 37 sub-rays:"
    energy = np.concatenate([echo.energy for echo in echoes])
    distance = np.concatenate([echo.distance for echo in echoes])
    return [
        compare(GROUP, f"{what} intensity", energies, energy, 2e-6, "reflectance"),
        compare(GROUP, f"{what} range", ranges, distance, 1e-6, "m"),
    ]
