"""Ranges of all the surfaces that a beam touched, each for itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.core.arrays import Floats
from app.model.scan import Scan
from app.services.bench.ghosts.truth import cells_of
from app.simulate.ranging import MOST_RETURNS, Pulsed
from app.simulate.receiver import Receiver
from app.simulate.scanner import trace_beams
from app.simulate.virtual_scan import Setup

APART = 0.004
"""Metres along the beam from which a second scan tells surfaces apart."""


def list_ranges(setup: Setup, scan: Scan) -> Floats:
    """Energy-weighted ranges of the second and third surface of each return, (n, 2) metres.

    The scene is scanned once more by a pulse so short that every surface gives a return of its
    own, without noise. NaN where there is no such surface, or it lies within `APART` of another
    one that is brighter.
    """
    short = Pulsed(pulse=1e-6, blend=APART, pick="all", least=0.0, most=MOST_RETURNS)
    tool = replace(setup.instrument, ranging=short, receiver=Receiver(threshold=0.0))
    echoes = trace_beams(setup.scene, setup.grid, tool, setup.file.position)
    weight = echoes.energy[:, tool.ranging_channel]
    surfaces = 1 + max(int(echoes.surface.max()), 0)
    key = echoes.cell * surfaces + echoes.surface[:, 0]
    known, which = np.unique(key, return_inverse=True)
    # A surface that a beam meets twice, such as a rolled leaf, has its mean.
    total = np.bincount(which, weight)
    ranges = np.bincount(which, weight * (echoes.distance - echoes.shift)) / total
    grid = cells_of(scan)
    cell = grid.row.astype(np.int64) * grid.columns + grid.column
    found = np.full((len(cell), 2), np.nan)
    for k, name in enumerate(("truth_surface_2", "truth_surface_3")):
        surface = scan.attributes[name].astype(np.int64)
        asked = cell * surfaces + surface
        place = np.minimum(np.searchsorted(known, asked), len(known) - 1)
        hit = (surface >= 0) & (known[place] == asked)
        found[hit, k] = ranges[place[hit]]
    return found
