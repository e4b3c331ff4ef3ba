"""Simulated scans of panels that face the scanner, whose every light and range is known.

SALCA goes without its digitised waveforms: what their threshold cuts off weak returns (4 % at a
reflectance of 0.05) is no part of any response. The table of waveforms looks at it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import Bools, Floats, Ints
from app.model.scan import Scan
from app.services.bench.simulate.rig import HERE, greys
from app.simulate.beam import BeamGrid
from app.simulate.detector import scale_of
from app.simulate.instrument import Instrument, get_instrument
from app.simulate.ranging import Pulsed
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Scene, Wall

STEP = 0.00125
"""Radians between beams; beams of neighbours overlap, and their intensities share nothing."""
SIDE = 12
"""Beams along a side of a panel that certainly lie on it with all of their cross-section."""
RIM = 4
"""More beams along a side of a panel."""
GAP = 2
"""Beams between panels."""
FULL = 0.99999


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """Full hits on the panels of one scan.

    Attributes
    ----------
    panel : (n,) number of each one's panel
    dn : (n, channels)
    distance : (n,) as measured, metres
    light : (n, channels)
        Apparent reflectance times power of the laser, without noise.
    """

    panel: Ints
    dn: Floats
    distance: Floats
    light: Floats

    def of(self, panel: int) -> Bools:
        """Which points lie on a panel."""
        return np.asarray(self.panel == panel)


def take_instrument(name: str) -> Instrument:
    """A preset, without waveforms."""
    tool = get_instrument(name)
    if isinstance(tool.ranging, Pulsed):
        return replace(tool, ranging=replace(tool.ranging, waveform=None))
    return tool


def see_panels(tool: Instrument, light: Sequence[float], distance: float, seed: int) -> Sight:
    """Scan panels side by side, each facing the scanner.

    Parameters
    ----------
    tool : Instrument
    light : sequence of float
        Reflectance times power of the laser of each panel: a weaker laser is a darker world.
    distance : float
        Metres.
    seed : int
        Of all noise.
    """
    pitch = SIDE + RIM + GAP
    turns = STEP * pitch * ((len(light) - 1) / 2 - np.arange(len(light)))
    half = distance * STEP * (SIDE + RIM) / 2
    walls = tuple(
        _face(float(turn), distance, half, value, len(tool.wavelengths_nm))
        for turn, value in zip(turns, light, strict=True)
    )
    scene = Scene("panels", walls=walls, wavelengths_nm=tool.wavelengths_nm)
    rows, columns = SIDE + RIM, pitch * len(light)
    grid = BeamGrid(STEP * (rows - 1) / 2, STEP * (columns - 1) / 2, STEP, rows, columns)
    return _read(scan_scene(scene, grid, tool, HERE, seed))


def _face(turn: float, distance: float, half: float, light: float, channels: int) -> Wall:
    c, s = float(np.cos(turn)), float(np.sin(turn))
    centre = (distance * c, distance * s, 0.0)
    return Wall(centre, (-s * half, c * half, 0.0), (0.0, 0.0, half), greys(*[light] * channels))


def _read(scan: Scan) -> Sight:
    truth = scan.attributes
    full = truth["truth_hit_fraction"] > FULL
    if "number_of_returns" in truth:
        full &= truth["number_of_returns"] == 1
    dn = [truth[channel.attribute][full] for channel in scan.channels]
    light = [truth[f"truth_reflectance_{c.wavelength_nm:.0f}"][full] for c in scan.channels]
    return Sight(
        truth["truth_surface"][full].astype(np.int64),
        np.stack(dn, axis=1).astype(float),
        np.linalg.norm(scan.xyz[full], axis=1),
        np.stack(light, axis=1).astype(float),
    )


def ends_of(tool: Instrument) -> tuple[float, float]:
    """Lowest and highest number of the scale."""
    dark, saturated = scale_of(tool.detector)
    return -np.inf if dark is None else dark, np.inf if saturated is None else saturated
