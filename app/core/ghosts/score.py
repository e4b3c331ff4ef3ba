"""Ghost points: how likely a point lies between two surfaces.

A beam that touches two surfaces reports a range between, or just beyond, them (Balduzzi 2011;
mixed pixels). Such a point continues no surface around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces, split_evenly
from app.core.footprint import BeamShape, check_beam
from app.core.ghosts import evidence
from app.core.ghosts.context import weigh_beams
from app.core.ghosts.density import score_by_density
from app.core.ghosts.evidence import find_doubtful
from app.core.ghosts.image import GhostImage, lay_out, try_layout
from app.core.ghosts.network import Network, load_network
from app.core.incidence import RADIUS
from app.core.neighbours.asked import as_points, each_once
from app.core.neighbours.steps import Cells, ScanGrid
from app.core.progress import QUIET, Progress

THRESHOLD = 0.5
BEAM = BeamShape(0.0015, float(np.deg2rad(0.014)))
"""Of the FARO LS880; what is taken where nobody told the beam."""
UNDECIDED = (0.04, 0.98)
"""After the first glance; below and above a second look changes no verdict."""
MIXED = 0.5
PIECE = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Scores of the points that were asked for.

    Attributes
    ----------
    score : (k,) 0 to 1
        NaN for points without coordinates or range. From `THRESHOLD` on: a ghost.
    method : {'scan grid', 'density'}
        How; without a scan grid the score is a weaker one.
    looked : int
        Points that needed more than a look at their window.
    """

    score: Floats
    method: str
    looked: int


def score_ghosts(
    xyz: Floats, scanner: AnyArray, points: Ints | None = None, grid: ScanGrid | None = None, *,
    beam: BeamShape | None = None, light: AnyArray | None = None, image: GhostImage | None = None,
    progress: Progress = QUIET,
) -> Scores:  # fmt: skip
    """Score points from 0 (lies on a surface) to 1 (ghost).

    On a scan grid: points whose eight beams beside lie level with them score 0. For the others
    a small network weighs how far off the beams of a window of 7 × 7 are and how straight lines
    run through the point; where that does not decide, a second one weighs the surfaces carried on
    to the beam, the beams beside, and the light. Both learned on simulated scans.

    Without a grid: points per ball against the density expected at that range, a weaker
    score, since it takes a thin or steep part for a ghost more easily.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    points : (k,) or None
        Numbers of the points asked for; None means all.
    grid : ScanGrid or None
    beam : BeamShape or None
        None: `BEAM`.
    light : (n,) or None
        Intensity: DN of a logarithmic amplifier, or the logarithm of power or reflectance.
    image : GhostImage or None
        What `lay_out` makes of these points, where it is at hand.
    progress : Progress

    Raises
    ------
    BadInput, WrongUse, Cancelled
        See `app.core.incidence.local_planes`; a beam that is none.
    """
    beam = BEAM if beam is None else beam
    check_beam(*beam)
    xyz, scanner = as_points(xyz), np.array(scanner, dtype=np.float64)
    asked, where = each_once(points, len(xyz))
    image = image or try_layout(xyz, scanner, grid)
    if image is None:
        score = score_by_density(xyz, scanner, points, RADIUS, progress)
        return Scores(score, "density", len(score))
    rows = np.arange(len(xyz)) if asked is None else asked
    glance, judgement = load_network("glance"), load_network("judgement")
    score, looked = score_by_networks(image, rows, beam, light, glance, judgement, progress)
    return Scores(score[where], "scan grid", looked)


def score_by_networks(
    image: GhostImage, asked: Ints, beam: BeamShape, light: AnyArray | None,
    glance: Network, judgement: Network, progress: Progress = QUIET,
) -> tuple[Floats, int]:  # fmt: skip
    """Scores of the asked points, (k,), and how many were looked at closely."""
    needed = asked if len(asked) == len(image.own) else _add_neighbours(image, asked)
    score, looked = see_all(image, needed, beam, glance, progress.part(0.0, 0.6))
    undecided = asked[(score[asked] > UNDECIDED[0]) & (score[asked] < UNDECIDED[1])]
    if len(undecided):
        score[undecided], _ = weigh_beams(
            image, score > MIXED, undecided, score, beam, light, judgement, progress.part(0.6, 1.0)
        )
    with np.errstate(invalid="ignore"):
        score[~(image.own > 0.0) | ~np.isfinite(image.own)] = np.nan
    return score[asked], looked


def _add_neighbours(image: GhostImage, asked: Ints) -> Ints:
    """The asked points, and all that the surfaces along their beams may rest on."""
    from scipy.ndimage import maximum_filter

    from app.core.kernels.ghost_image import MARGIN
    from app.core.kernels.ghost_surfaces import DEEPEST

    cells = image.cells
    chosen: Bools = np.zeros((cells.rows, cells.columns), bool)
    chosen[cells.row[asked], cells.column[asked]] = True
    around = maximum_filter(
        chosen,
        2 * (MARGIN + DEEPEST) + 1,
        mode=("constant", "wrap" if image.steps.seam else "constant"),
    )
    return np.flatnonzero(around[cells.row, cells.column])


def see_all(
    image: GhostImage, points: Ints, beam: BeamShape, glance: Network, progress: Progress = QUIET
) -> tuple[Floats, int]:
    """First score of some points, (n,), 0 for others; and how many were looked at closely."""
    score = np.zeros(len(image.own))
    looked: list[int] = []

    def work(first: int, last: int) -> None:
        places = find_doubtful(image, points, first, last)
        score[points[places]] = evidence.glance(image, points, places, beam, glance)
        looked.append(len(places))

    run_in_pieces(work, split_evenly(len(points), PIECE), progress, "ghost score")
    return score, sum(looked)


@cache
def warm_up() -> None:
    """Compile, or load, the kernels once, so that no measured second holds it."""
    row, column = (a.ravel().astype(np.int32) for a in np.mgrid[:16, :16])
    away = np.where(column < 8, 1.0, 1.05) + np.where(column == 8, 0.02, 0.0)
    xyz = np.stack([away, column / 1000.0 * away, row / 1000.0 * away], axis=1)
    image = lay_out(xyz, np.zeros(3), Cells(16, 16, row, column))
    some = np.arange(len(xyz))
    score, _ = see_all(image, some, BEAM, load_network("glance"))
    weigh_beams(image, score > MIXED, some, score, BEAM, away, load_network("judgement"))
