"""The edge of a wall, seen by a Gaussian beam: its profile, and how many beams it splits."""

from __future__ import annotations

import numpy as np

from app.core.arrays import Floats
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import EDGE, beam_row, greys, half_wall, send, silent, wall_at
from app.simulate.beam import BeamGrid, Bundle
from app.simulate.truth import GHOST

GROUP = "edge"
PROFILES = {37: 0.08, 91: 0.04, 1000: 0.006}
"""Sub-rays, and how far a profile made of so many steps may be off the smooth one."""
NEAR, FAR = 3.0, 3.4
LEAN = 0.1
"""Radians by which an edge leans, so that columns of beams meet it everywhere."""


def check_edge(quick: bool) -> list[Check]:
    """All checks of this file."""
    profiles = {rays: _profile_of(Bundle(rays=rays), 201) for rays in PROFILES}
    what = "intensity across an edge: cut Gaussian,"
    return [
        *(compare(GROUP, f"{what} {n} sub-rays", *profiles[n], PROFILES[n]) for n in PROFILES),
        _check_error_function(profiles[37][1]),
        _count_split(0.0002 if quick else 0.0001),
        _count_ghosts(0.0002 if quick else 0.0001),
    ]


def _profile_of(bundle: Bundle, beams: int) -> tuple[Floats, Floats]:
    """Share before the edge by closed form, and as scanned, across 1.2 radii either way."""
    radius = bundle.radius(NEAR)
    grid = beam_row(beams, 2.4 * radius / NEAR / (beams - 1))
    echo = send([half_wall(NEAR, greys(1.0, 1.0))], silent(bundle=bundle), grid)
    found = np.zeros(beams)
    found[echo.cell] = echo.energy[:, 1]
    return cut_gaussian((NEAR * np.tan(grid.azimuth) - EDGE) / radius), found


def cut_gaussian(place: Floats) -> Floats:
    """Share of a Gaussian exp(−2 s²), cut at s = 1, on the side below `place` (in radii)."""
    from scipy.special import erf

    s = np.linspace(-1.0, 1.0, 20_001)
    density = np.exp(-2 * s**2) * erf(np.sqrt(2 * np.maximum(1 - s**2, 0.0)))
    share = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.asarray(np.interp(place, s, share / share[-1]))


def _check_error_function(found: Floats) -> Check:
    """The width from 16 to 84 %, one σ of the error function either way; σ is half a radius."""
    from scipy.special import erf

    s = np.linspace(-1.2, 1.2, len(found))[::-1]
    whole = (1 + erf(np.sqrt(2.0) * s)) / 2
    widths = [
        np.interp(0.84, curve[::-1], s[::-1]) - np.interp(0.16, curve[::-1], s[::-1])
        for curve in (whole, found)
    ]
    what = "edge width, 16 to 84 %: error function without the cut"
    return compare(GROUP, what, widths[0], widths[1], 0.15, relative=True)


def _scan_edge(step: float) -> tuple[BeamGrid, Floats, Floats]:
    """A field of beams on a leaning edge: the grid, surfaces touched and distance off them."""
    grid = BeamGrid(0.02, 0.01, step, round(0.04 / step), round(0.02 / step))
    walls = [half_wall(NEAR, greys(0.5, 0.5), LEAN), wall_at(FAR, greys(0.5, 0.5))]
    echo = send(walls, silent(), grid)
    return grid, echo.touched.astype(float), echo.off_surface


def _count_split(step: float) -> Check:
    """Beams on both walls: the edge's length times the width of all sub-rays across it."""
    grid, touched, _ = _scan_edge(step)
    bundle = silent().bundle
    across = bundle.subrays()[:, :2] @ [np.cos(LEAN), np.sin(LEAN)]
    width = np.ptp(across) * bundle.radius(NEAR) / NEAR
    expected = width / np.cos(LEAN) / grid.step * grid.rows
    what = "beams that an edge splits: its length × the beam's width"
    return compare(GROUP, what, expected, (touched > 1).sum(), 0.03, relative=True)


def _count_ghosts(step: float) -> Check:
    """Ghosts: the part of that width in which the closed form of the range is off both walls."""
    from app.simulate.ranging import phase_range

    grid, _, off = _scan_edge(step)
    bundle = silent().bundle
    place = np.linspace(-1.0, 1.0, 4001)
    share = cut_gaussian(place)
    away = np.array([NEAR, FAR])
    ranges = np.array([phase_range(away, np.array([s, 1 - s]) / away**2) for s in share])
    ghost = np.abs(ranges[:, None] - away).min(axis=1) > GHOST
    width = ghost.mean() * 2 * bundle.radius(NEAR) / NEAR
    expected = width / np.cos(LEAN) / grid.step * grid.rows
    what = "ghosts of an edge: its length × the ghostly part of the beam's width"
    return compare(GROUP, what, expected, (off > GHOST).sum(), 0.1, relative=True)
