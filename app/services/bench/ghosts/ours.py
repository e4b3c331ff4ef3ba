"""Our own way, as the fields of a scan and the command use it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core import ghosts
from app.core.arrays import Bools, Floats
from app.core.footprint import BeamShape
from app.model.ghost_fields import light_of
from app.model.parameters import Beam
from app.model.scan import Scan
from app.model.state import ScanState
from app.services.bench.ghosts.truth import cells_of, ranges_of

NAME = "Leafscope"


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a method says of each point.

    Attributes
    ----------
    called : (n,) bool
        At the default setting.
    score : (n,)
        Larger is more of a ghost; NaN where nothing can be said.
    corrected : (n,) bool
        Points that are put back on a surface.
    ranges : (n,) metres
        Where ghosts belong, along their beams; as scanned elsewhere.
    confidence : (n,)
        Of the corrections; NaN where nothing is called.
    """

    called: Bools
    score: Floats
    corrected: Bools
    ranges: Floats
    confidence: Floats


def judge(scan: Scan, beam: Beam) -> Answer:
    """Find the ghost points of a scan, and put back those that can be."""
    scanner, grid = scan.scanner("ghost points"), cells_of(scan)
    shape = BeamShape(beam.radius, beam.half_divergence)
    light = light_of(ScanState.fresh(scan))
    image = ghosts.try_layout(scan.xyz, scanner, grid)
    score = ghosts.score_ghosts(scan.xyz, scanner, beam=shape, light=light, image=image).score
    called = score >= ghosts.THRESHOLD
    places = np.flatnonzero(called)
    found = ghosts.correct_ghosts(
        scan.xyz, scanner, places, score, beam=shape, light=light, image=image
    )
    ranges, corrected = ranges_of(scan), np.zeros(len(score), bool)
    corrected[places] = found.corrected
    ranges[places] = found.ranges
    confidence = np.full(len(score), np.nan)
    confidence[places] = found.confidence
    return Answer(called, score, corrected, ranges, confidence)
