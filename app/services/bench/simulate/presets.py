"""What each preset writes down for a 50 % panel, against its response, worked out here."""

from __future__ import annotations

import numpy as np

from app.core.units import to_radians
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import HERE, greys, wall_at
from app.simulate.beam import BeamGrid
from app.simulate.detector import Amplifier, Ideal, Linear, Logarithmic
from app.simulate.instrument import Instrument, list_instruments
from app.simulate.range_effect import Hancock, InverseSquare
from app.simulate.ranging import Pulsed
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Scene
from app.simulate.virtual_scan import set_noise

GROUP = "presets"
RANGES = (2.5, 4.4, 8.0, 15.0)
RHO = 0.5
BEAMS = 20


def check_presets(_quick: bool) -> list[Check]:
    """One check per preset: all its channels at `RANGES`; means of 400 beams."""
    return [_check(tool) for tool in list_instruments()]


def _check(tool: Instrument) -> Check:
    silent = set_noise(tool, "none")
    expected = [_respond(silent, away, k) for away in RANGES for k in _channels(tool)]
    found = [value for away in RANGES for value in _scan_panel(silent, away)]
    what = f"{tool.title}: 50 % panel at 2.5 to 15 m"
    unit = tool.detector.kind
    # Electronic noise of 400 beams, and the feet of a pulse that the gate of a record cuts off.
    feet = isinstance(tool.ranging, Pulsed) and tool.ranging.waveform is not None
    limit = 1e-6 if isinstance(tool.detector, Ideal) and not feet else 1.0
    limit = 0.02 * RHO if isinstance(tool.detector, Ideal) and feet else limit
    return compare(GROUP, what, expected, found, limit, unit)


def _channels(tool: Instrument) -> range:
    return range(len(tool.wavelengths_nm))


def _scan_panel(tool: Instrument, away: float) -> list[float]:
    """Mean value of each channel."""
    panel = wall_at(away, greys(*[RHO for _ in _channels(tool)]))
    scene = Scene("panel", walls=(panel,), wavelengths_nm=tool.wavelengths_nm)
    step = float(to_radians(0.01))
    grid = BeamGrid(step * BEAMS / 2, step * BEAMS / 2, step, BEAMS, BEAMS)
    scan = scan_scene(scene, grid, tool, HERE, seed=5)
    return [float(np.mean(scan.attributes[channel.attribute])) for channel in scan.channels]


def _respond(tool: Instrument, away: float, k: int) -> float:
    """The response of a channel as science 1.3 and 1.4 print it, cut at the ends of the scale."""
    detector = tool.detector
    if isinstance(detector, Ideal):
        return RHO
    light = RHO * _fall(detector, away, k)
    if isinstance(detector, Linear):
        value = (light - detector.b[k]) / detector.a[k]
    elif isinstance(detector, Logarithmic):
        value = detector.a0[k] * np.log(light) / np.log(10) + detector.a1[k]
    else:
        knee = 1 - np.exp(-detector.k[k] * light)
        value = (detector.m[k] * light + detector.c[k]) * knee
    return float(np.clip(value, detector.scale.dark, detector.scale.saturated))


def _fall(detector: Amplifier, away: float, k: int) -> float:
    """f(d) / f(reference)."""
    effect = detector.range_effect
    if isinstance(effect, InverseSquare):
        return (effect.reference**2 + effect.near**2) / (away**2 + effect.near**2)
    if isinstance(effect, Hancock):
        a, k2, k3 = effect.a[k], effect.k2[k], effect.k3[k]
        here, there = ((1 - np.exp(-k2 * r)) ** k3 / r**a for r in (away, effect.reference))
        return float(here / there)
    return 1.0
