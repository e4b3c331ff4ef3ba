"""Range noise: as large as stated, and as neighbours share it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.core.units import to_radians
from app.services.bench.checks import Check, compare
from app.services.bench.simulate.rig import HERE, greys, wall_at
from app.simulate.beam import BeamGrid
from app.simulate.instrument import get_instrument
from app.simulate.receiver import Correlation
from app.simulate.simulation import scan_scene
from app.simulate.surfaces import Scene

GROUP = "noise"
PRINTED = {0.9: 0.0026, 0.1: 0.0052}
"""σ of an unfiltered LS880 at 10 m by reflectance, metres: science 7."""


def check_noise(quick: bool) -> list[Check]:
    """σ by reflectance, then the 3 × 3 correlation; limits are 4 σ of the estimates."""
    side = 100 if quick else 300
    size = 4 / side
    white = [_draw_errors(rho, side, "white") for rho in PRINTED]
    filtered = _draw_errors(0.9, side, "filtered")
    sigmas = [errors.std() for errors in white]
    stated = list(PRINTED.values())
    shared = [2 / 3, 2 / 3, 4 / 9]
    lag = [_correlate(filtered, 0, 1), _correlate(filtered, 1, 0), _correlate(filtered, 1, 1)]
    none = [_correlate(white[0], 0, 1), _correlate(white[0], 1, 1)]
    far = [_correlate(filtered, 0, 3), _correlate(filtered, 3, 0)]
    thrice = 3 * size
    return [
        compare(GROUP, "σ at 90 and 10 %, LS880", stated, sigmas, size, relative=True),
        compare(GROUP, "σ when filtered: the same", 0.0026, filtered.std(), thrice, relative=True),
        compare(GROUP, "filtered: neighbours share 2/3, 2/3, 4/9", shared, lag, thrice),
        compare(GROUP, "filtered: three cells apart nothing is shared", [0, 0], far, thrice),
        compare(GROUP, "white: neighbours share nothing", [0, 0], none, size),
    ]


def _draw_errors(rho: float, side: int, correlation: Correlation) -> Floats:
    """Range error of each beam on a wall at 10 m, (side, side) metres."""
    tool = get_instrument("ls880")
    tool = replace(tool, receiver=replace(tool.receiver, correlation=correlation))
    scene = Scene("wall", walls=(wall_at(10.0, greys(rho)),), wavelengths_nm=tool.wavelengths_nm)
    step = float(to_radians(0.005))
    grid = BeamGrid(step * side / 2, step * side / 2, step, side, side)
    scan = scan_scene(scene, grid, tool, HERE, seed=11)
    errors = np.linalg.norm(scan.xyz, axis=1) - scan.attributes["truth_range"]
    return np.asarray(errors.reshape(side, side))


def _correlate(field: Floats, rows: int, columns: int) -> float:
    """Correlation of cells that lie so many rows and columns apart."""
    tall, wide = field.shape
    first = field[: tall - rows, : wide - columns].ravel()
    return float(np.corrcoef(first, field[rows:, columns:].ravel())[0, 1])
