"""Nothing of a beam is lost or made: shares sum to one, walls return what they must."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

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
from app.simulate.beam import Bundle
from app.simulate.instrument import get_instrument
from app.simulate.ranging import PhaseShift, Pulsed

GROUP = "energy"
RAYS = (1, 2, 7, 19, 37, 61, 91)
RANGES = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
FAR = PhaseShift((153.6, 9.6, 1.2))


def check_energy(_quick: bool) -> list[Check]:
    """All checks of this file."""
    return [*_check_shares(), *_check_walls(), _check_channels(), _check_returns()]


def _check_shares() -> list[Check]:
    sums = [Bundle(rays=rays).subrays()[:, 2].sum() for rays in RAYS]
    instrument, grid = silent(), beam_row(81, 2e-5)
    walls = [half_wall(2.0, greys(0.5, 0.3)), wall_at(3.0, greys(0.6, 0.4))]
    both, front = send(walls, instrument, grid), send(walls[:1], instrument, grid)
    on_front, _, _ = split_at_edge(grid, instrument.bundle, 2.0, 3.0)
    expected = on_front @ instrument.bundle.subrays()[:, 2]
    found = np.zeros(grid.columns)
    found[front.cell] = front.share[:, 0]
    shares = both.share.sum(axis=1)
    return [
        compare(GROUP, "shares of 1 to 91 sub-rays sum to 1", np.ones(len(RAYS)), sums, 1e-12),
        compare(GROUP, "components of a beam on two walls sum to 1", np.ones(81), shares, 1e-12),
        compare(GROUP, "share on a half wall: sub-rays before its edge", expected, found, 1e-12),
    ]


def _check_walls() -> list[Check]:
    instrument = silent(FAR)
    echoes = [send([wall_at(away, greys(0.5, 0.3))], instrument) for away in RANGES]
    energy = np.concatenate([echo.energy for echo in echoes])
    distance = np.concatenate([echo.distance for echo in echoes])
    expected = np.tile([0.5, 0.3], (len(RANGES), 1))
    what = "a matt wall at 1 to 50 m returns"
    return [
        compare(GROUP, f"{what} its reflectance", expected, energy, 1e-6, relative=True),
        compare(GROUP, f"{what} its range", RANGES, distance, 1e-6, "m"),
    ]


def _check_channels() -> Check:
    tool = get_instrument("hsl")
    rho = tuple(np.linspace(0.05, 0.6, len(tool.wavelengths_nm)))
    instrument = replace(
        silent(bundle=tool.bundle), wavelengths_nm=tool.wavelengths_nm, ranging_channel=5
    )
    echo = send([wall_at(4.0, greys(*rho))], instrument)
    what = "eight channels of a wall sum to their reflectances"
    return compare(GROUP, what, sum(rho), echo.energy.sum(), 1e-6, relative=True)


def _check_returns() -> Check:
    """The returns of a beam, together, are what one return of all its sub-rays is."""
    walls = [half_wall(2.0, greys(0.5, 0.3)), wall_at(3.5, greys(0.6, 0.4))]
    grid = beam_row(81, 2e-5)
    apart = send(walls, silent(Pulsed(0.15, 0.25, "all", 0.0)), grid)
    joined = send(walls, silent(Pulsed(0.15, 9.0, "all", 0.0)), grid)
    received = np.zeros((grid.columns, 2))
    np.add.at(received, apart.cell, apart.energy / apart.distance[:, None] ** 2)
    expected = joined.energy / joined.distance[:, None] ** 2
    what = "all returns of a pulse together bring what was sent back"
    return compare(GROUP, what, expected, received[joined.cell], 1e-12, relative=True)
