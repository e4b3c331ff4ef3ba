"""What the checks set up: silent instruments, walls, single beams, and sub-rays traced in numpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.core.arrays import Bools, Floats
from app.core.units import to_radians
from app.simulate.beam import BeamGrid, Bundle
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.material import Material, glossy, matt
from app.simulate.ranging import Ranging
from app.simulate.receiver import Receiver
from app.simulate.scanner import Echoes, trace_beams
from app.simulate.surfaces import Leaf, Scene, Wall

HERE = (0.0, 0.0, 0.0)
LEAF = (glossy(0.48, 0.88, 0.22), glossy(0.27, 0.72, 0.30))
THIN = Bundle(exit_diameter=0.0, half_divergence=0.0, rays=1)
WIDE = 3.0
"""Half width of a wall, metres."""
EDGE = 1.234e-5
"""Where half walls begin, metres left of x: on x itself a beam's axis would lie on the edge."""


def silent(ranging: Ranging | None = None, bundle: Bundle | None = None) -> Instrument:
    """The two-colour instrument without noise and with no weakest return."""
    tool = get_instrument("two_colour")
    return replace(
        tool,
        receiver=Receiver(threshold=0.0),
        ranging=tool.ranging if ranging is None else ranging,
        bundle=tool.bundle if bundle is None else bundle,
    )


def single_beam() -> BeamGrid:
    """One beam along x."""
    return BeamGrid(0.0, 0.0, 0.001, 1, 1)


def beam_row(count: int, step: float) -> BeamGrid:
    """Beams side by side around x; `step` in radians."""
    return BeamGrid(0.0, step * (count - 1) / 2, step, 1, count)


def wall_at(distance: float, material: Material, incidence_deg: float = 0.0) -> Wall:
    """A wall that the beam along x meets in its middle at the given angle."""
    tilt = float(to_radians(incidence_deg))
    across = (float(-np.sin(tilt)) * WIDE, float(np.cos(tilt)) * WIDE, 0.0)
    return Wall((distance, 0.0, 0.0), across, (0.0, 0.0, WIDE), material)


def half_wall(distance: float, material: Material, lean: float = 0.0) -> Wall:
    """A wall that fills all y above `EDGE`; its edge leans by `lean` radians."""
    c, s = float(np.cos(lean)) * WIDE, float(np.sin(lean)) * WIDE
    return Wall((distance, EDGE + c, s), (0.0, c, s), (0.0, -s, c), material)


def greys(*rho: float) -> Material:
    """A matt material, one reflectance per channel."""
    return tuple(matt(value) for value in rho)


def send(
    surfaces: Sequence[Wall | Leaf],
    instrument: Instrument,
    grid: BeamGrid | None = None,
    hierarchy: bool = True,
) -> Echoes:
    """Echoes of beams in a scene of walls and leaves."""
    scene = Scene(
        "bench",
        tuple(s for s in surfaces if isinstance(s, Leaf)),
        walls=tuple(s for s in surfaces if isinstance(s, Wall)),
        wavelengths_nm=instrument.wavelengths_nm,
    )
    return trace_beams(scene, grid or single_beam(), instrument, HERE, hierarchy=hierarchy)


def subrays_of(grid: BeamGrid, bundle: Bundle) -> tuple[Floats, Floats, Floats]:
    """Starts and directions, (beams, rays, 3), and shares, (rays,), of a row of level beams."""
    table = bundle.subrays()
    side = grid.azimuth[:, None, None]
    left = np.concatenate([-np.sin(side), np.cos(side), 0 * side], axis=2)
    axis = np.concatenate([np.cos(side), np.sin(side), 0 * side], axis=2)
    offset = table[None, :, :1] * left + table[None, :, 1:2] * np.array([0.0, 0.0, 1.0])
    start = offset * (bundle.exit_diameter / 2)
    return start, axis + offset * np.tan(bundle.half_divergence), table[:, 2]


def split_at_edge(
    grid: BeamGrid, bundle: Bundle, near: float, far: float
) -> tuple[Bools, Floats, Floats]:
    """Sub-rays of level beams on a half wall at x = `near`, all others on a wall at x = `far`.

    Returns
    -------
    front : (beams, rays), on the half wall
    distance : (beams, rays), along the beam
    facing : (beams, rays), cos ω
    """
    start, direction, _ = subrays_of(grid, bundle)
    to_near = (near - start[..., 0]) / direction[..., 0]
    front = start[..., 1] + to_near * direction[..., 1] >= EDGE
    distance = np.where(front, to_near, (far - start[..., 0]) / direction[..., 0])
    facing = direction[..., 0] / np.linalg.norm(direction, axis=2)
    return front, distance, facing
