"""Ghosts put back, along their beams, on the surface that owns most of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.footprint import BeamShape
from app.core.ghosts.context import weigh_beams
from app.core.ghosts.image import GhostImage, try_layout
from app.core.ghosts.network import load_network
from app.core.ghosts.score import BEAM
from app.core.neighbours.asked import as_points, each_once
from app.core.neighbours.steps import ScanGrid
from app.core.progress import QUIET, Progress

SURE = 0.8
"""Confidence from which a ghost is put back."""
CLEAN = 0.3
"""Score up to which a point supports a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Corrections:
    """Where ghosts belong.

    Attributes
    ----------
    ranges : (g,) metres
        Of the surface that owns most of the beam; NaN where there is none.
    confidence : (g,) 0 to 1
        Probability that the range lies within 2 σ of the truth, and nearer to it than before.
    moved : (g, 3) metres
        Points put there where that is sure enough; the others as they were.
    corrected : (g,) bool
    """

    ranges: Floats
    confidence: Floats
    moved: Floats
    corrected: Bools


def correct_ghosts(
    xyz: Floats, scanner: AnyArray, ghosts: Ints, score: Floats, grid: ScanGrid | None = None, *,
    beam: BeamShape | None = None, light: AnyArray | None = None, image: GhostImage | None = None,
    sure: float = SURE, clean: float = CLEAN, progress: Progress = QUIET,
) -> Corrections:  # fmt: skip
    """Put ghosts on the surface nearest to them in range.

    The surface with most of the energy draws the mixed range to itself. Surfaces rest on clean
    beams only; a steep, lengthened part inside a leaf comes back onto the leaf.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    ghosts : (g,)
        Numbers of the ghosts.
    score : (n,) 0 to 1
        Of all points, as `score_ghosts` gives it; what the user judged is 0 or 1.
    grid : ScanGrid or None
        Without one no ghost is moved: what its beam touched cannot be told.
    beam, light, image :
        As for `score_ghosts`.
    sure : float
        Confidence from which a ghost is moved.
    clean : float
        Score up to which a point supports a surface; at most `CLEAN` counts. Below the threshold
        of ghosts, so that it does not matter which of them are asked for.
    progress : Progress

    Raises
    ------
    BadInput, WrongUse, Cancelled
    """
    xyz, scanner = as_points(xyz), np.array(scanner, dtype=np.float64)
    ghosts = np.array(ghosts, dtype=np.int64)
    each_once(ghosts, len(xyz))
    mixed: Bools = ~(score <= min(clean, CLEAN))
    mixed[ghosts] = True
    image = image or try_layout(xyz, scanner, grid)
    if image is None:
        unknown = np.full(len(ghosts), np.nan)
        return _move(xyz[ghosts], scanner, unknown, unknown, sure)
    beam = BEAM if beam is None else beam
    glance = np.where(np.isnan(score), 1.0, score)
    confidence, ranges = weigh_beams(
        image, mixed, ghosts, glance, beam, light, load_network("confidence"), progress
    )
    return _move(xyz[ghosts], scanner, ranges, confidence, sure)


def _move(
    points: Floats, scanner: Floats, ranges: Floats, confidence: Floats, sure: float
) -> Corrections:
    confidence = np.where(np.isfinite(ranges), confidence, 0.0)
    beams = points - scanner
    own = np.linalg.norm(beams, axis=1)
    corrected = np.isfinite(own) & (own > 0.0) & np.isfinite(ranges) & (confidence >= sure)
    moved = points.copy()
    moved[corrected] = scanner + beams[corrected] * (ranges / own)[corrected, None]
    return Corrections(ranges, confidence, moved, corrected)
