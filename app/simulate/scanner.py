"""The virtual scanner: a scene and a grid of beams in, a scan that knows its truth out."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from app.core.arrays import AnyArray, Floats, read_only
from app.core.units import to_degrees
from app.model.scan import Channel, Grid, Pose, Scan, Vector
from app.simulate.beam import BeamGrid, Bundle
from app.simulate.detector import Receiver, add_intensity_noise, add_range_noise
from app.simulate.ranging import WAVELENGTHS, count_octaves
from app.simulate.surfaces import Scene
from app.simulate.tables import tabulate_scene, tabulate_tiles

if TYPE_CHECKING:
    from app.core.kernels.simulate import BeamTable

GHOST = 0.006
"""A range farther than this, metres, from all that the beam touched is a ghost."""
UNSURE = 0.002
BAND = 16
"""Rows that one thread takes at a time."""


@dataclass(frozen=True, slots=True)
class Instrument:
    """A phase-shift scanner.

    Attributes
    ----------
    bundle : Bundle
    receiver : Receiver
    modulation : tuple of float
        Modulation wavelengths, coarse to fine, metres.
    ranging_channel : int
        Channel of the scene whose laser measures the range.
    """

    bundle: Bundle = field(default_factory=Bundle)
    receiver: Receiver = field(default_factory=Receiver)
    modulation: tuple[float, ...] = WAVELENGTHS
    ranging_channel: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Echoes:
    """Noise-free outcome of each beam, row by row; NaN or −1 where nothing came back.

    Attributes
    ----------
    distance : (n,) range that the scanner reports, metres
    off_surface : (n,) from there to the nearest surface touched, metres
    shift : (n,) reported range minus that of the surface with most energy, metres
    share : (n,) share of the beam's energy on that surface
    incidence : (n,) angle there, at the sub-ray nearest to the beam's centre, radians
    energy : (n, channels) reflectance × share, corrected by the reported range
    surface : (n,) index of the surface with most energy
    """

    distance: Floats
    off_surface: Floats
    shift: Floats
    share: Floats
    incidence: Floats
    energy: Floats
    surface: AnyArray


def trace_beams(scene: Scene, grid: BeamGrid, instrument: Instrument, origin: Vector) -> Echoes:
    """Send every beam of a grid into a scene.

    The energy of a sub-ray falls off with the square of its distance and follows the
    Lambert–Beckmann reflectance of what it hits; the range comes from `ranging.phase_range`.
    """
    from app.core.kernels.simulate import trace

    table = tabulate_scene(scene)
    beam = _tabulate_beam(instrument)
    place = np.array(origin, np.float64)
    tiles = tabulate_tiles(grid, instrument.bundle, table.sphere, place)
    elevation, azimuth = grid.elevation, grid.azimuth
    cells = grid.rows * grid.columns
    truth = np.full((cells, 5), np.nan)
    energy = np.zeros((cells, len(scene.wavelengths_nm)))
    surface = np.full(cells, -1, np.int32)

    def trace_band(first: int) -> None:
        band = (first, min(first + BAND, grid.rows))
        trace(table, beam, tiles, place, elevation, azimuth, band, truth, energy, surface)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(trace_band, range(0, grid.rows, BAND)))
    distance, off, shift, share, incidence = truth.T
    return Echoes(distance, off, shift, share, incidence, energy, surface)


def scan_scene(
    scene: Scene,
    grid: BeamGrid,
    instrument: Instrument,
    origin: Vector = (0.0, 0.0, 0.0),
    seed: int = 0,
) -> Scan:
    """Scan a scene; the same seed gives the same scan, bit for bit.

    Returns
    -------
    Scan
        Channels ``reflectance_<nm>``, the grid with its no-return cells, and per point

        - ``truth_leaf`` int32, −1 on stems and walls;
        - ``truth_incidence`` degrees, on the surface with most of the beam's energy;
        - ``truth_hit_fraction``, the share of the beam on that surface;
        - ``truth_range`` without noise, metres;
        - ``truth_distance`` from there to the nearest surface that the beam touched, metres;
        - ``truth_range_shift``, truth_range minus the range of the surface with most energy;
        - ``truth_ghost`` 1: truth_distance > 6 mm; 2: unsure, 2 to 6 mm; 0: on a surface.
    """
    echoes = trace_beams(scene, grid, instrument, origin)
    hit = np.flatnonzero(echoes.surface >= 0)
    random = np.random.default_rng(seed)
    receiver = instrument.receiver
    ranging = echoes.energy[hit, instrument.ranging_channel]
    distance = add_range_noise(echoes.distance[hit], ranging, receiver, random)
    values = add_intensity_noise(echoes.energy[hit], receiver, random)
    xyz = np.array(origin) + distance[:, None] * grid.directions.reshape(-1, 3)[hit]
    channels = tuple(_name_channel(nm, receiver) for nm in scene.wavelengths_nm)
    attributes = {c.attribute: values[:, k].astype(np.float32) for k, c in enumerate(channels)}
    attributes |= _tell_truth(scene, echoes, hit)
    return Scan(
        name=scene.name,
        xyz=read_only(xyz),
        attributes={key: read_only(column) for key, column in attributes.items()},
        channels=channels,
        pose=Pose((float(origin[0]), float(origin[1]), float(origin[2]))),
        grid=place_in_grid(grid, hit),
        metadata={"instrument": "simulated phase-shift scanner", "seed": str(seed)},
    )


def place_in_grid(grid: BeamGrid, hit: AnyArray) -> Grid:
    """Cells of the returns `hit` (row · columns + column); the rest had no return."""
    silent = np.ones(grid.rows * grid.columns, bool)
    silent[hit] = False
    return Grid(
        grid.rows,
        grid.columns,
        read_only((hit // grid.columns).astype(np.int32)),
        read_only((hit % grid.columns).astype(np.int32)),
        read_only(np.flatnonzero(silent)),
    )


def _tabulate_beam(instrument: Instrument) -> BeamTable:
    from app.core.kernels.simulate import BeamTable

    return BeamTable(
        instrument.bundle.subrays(),
        instrument.bundle.exit_diameter / 2,
        float(np.tan(instrument.bundle.half_divergence)),
        np.array(instrument.modulation, float),
        count_octaves(instrument.modulation),
        instrument.ranging_channel,
        instrument.receiver.threshold,
    )


def _name_channel(nm: float, receiver: Receiver) -> Channel:
    name = f"reflectance_{nm:.0f}"
    note = f"simulated, noise {receiver.intensity_noise:.1%} of the value"
    return Channel(name, name, nm, "reflectance", note)


def _tell_truth(scene: Scene, echoes: Echoes, hit: AnyArray) -> dict[str, AnyArray]:
    off = echoes.off_surface[hit]
    ghost = np.where(off > GHOST, 1, np.where(off > UNSURE, 2, 0))
    return {
        "truth_leaf": scene.labels()[echoes.surface[hit]],
        "truth_incidence": to_degrees(echoes.incidence[hit]).astype(np.float32),
        "truth_ghost": ghost.astype(np.uint8),
        "truth_hit_fraction": echoes.share[hit].astype(np.float32),
        "truth_range": echoes.distance[hit],
        "truth_distance": off.astype(np.float32),
        "truth_range_shift": echoes.shift[hit].astype(np.float32),
    }
