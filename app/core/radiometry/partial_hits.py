"""Which share of a beam lies on the surface that its point was measured on.

A beam at the edge of a leaf lights the leaf with a part of its cross-section only, and its
intensity says nothing about reflectance: radiometry takes full hits (Hancock 2017, Junttila
2016). The share is told from the scan grid, from the ranges around:

- Beams that follow one another without a jump, or in line up a slope, are of one surface. Around
  each point those of its own surface are looked for as far as its beam reaches (a beam more than
  11 cells wide to either side counts as one of 11).
- An edge lies anywhere between two beams: the Gaussian beam is summed over the interpolated
  membership of the beams around.
- A mixed range (part of no 2 × 2 beams of one surface) counts to the surface that it is nearer to.
  A beam with several returns lies half on either surface; beside it, one with a single return lies
  on one surface.
- A much nearer surface, or one before the sky, is reported while the beam still touches it: its
  edge is taken to lie inside its last points, by as much as 1 / r² alone explains.
- Beams without return are off every surface, unless all eight around them are on the point's own
  (a dropout). Beyond the border of the scan the surface goes on as it does there.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from app.core.arrays import AnyArray, Bools, Floats, Ints
from app.core.chunks import run_in_pieces
from app.core.errors import BadInput
from app.core.footprint import check_beam
from app.core.neighbours.asked import as_points, each_once, slots_of
from app.core.neighbours.range_image import TILE, RangeImage, build_image
from app.core.neighbours.steps import Cells, ScanGrid, UnusableGrid, as_cells
from app.core.normals.image import mark_tiles
from app.core.progress import QUIET, Progress

FULL_HIT = 0.98
"""From this share on a point counts as a full hit: what is missing is less than a channel's noise.

On simulated scans of leaves and panels (LS880, X330, SALCA) 91 to 99.8 % of the points above it
have a true share of at least 0.98, their mean true share is 0.988 to 0.999, and 97 to 100 % of
the true full hits are among them. From 0.97 to 0.99 the mean hardly changes, while each step up
loses full hits beside edges.
"""
RAYS = 61
GATES, LEAST_GATE = 4.0, 0.002
"""Neighbouring ranges of one surface differ by so many σ of the noise, or by so many metres."""
GOLDEN = float(np.pi * (3 - np.sqrt(5)))
PLACES = 65


def hit_fraction(
    xyz: Floats, scanner: AnyArray, grid: ScanGrid | None, beam_radius: float,
    half_divergence: float, points: Ints | None = None, progress: Progress = QUIET,
) -> Floats:  # fmt: skip
    """Share of each beam's cross-section that lies on the surface of its own point.

    How it is told stands at the head of this module.

    Parameters
    ----------
    xyz : (n, 3) metres
    scanner : (3,) metres
    grid : ScanGrid or None
    beam_radius : float
        Radius of the beam at the aperture, metres.
    half_divergence : float
        Half of the full divergence, radians.
    points : (k,) or None
        Numbers of the points asked for; None means all.
    progress : Progress

    Returns
    -------
    (k,) float
        0 to 1; NaN for points without coordinates or range. From `FULL_HIT` on: a full hit.
        Pulsed scanners that give the first return alone report a near surface from a few per
        cent of the beam on; at its rim the share comes out too high.

    Raises
    ------
    BadInput
        There is no grid, or its rows and columns do not follow the beams.
    WrongUse
        A point number does not exist, or the beam is none.
    Cancelled
    """
    check_beam(beam_radius, half_divergence)
    if grid is None:
        raise _no_grid("the scan has none, and none could be recovered")
    xyz = as_points(xyz)
    scanner = np.array(scanner, dtype=np.float64)
    asked, where = each_once(points, len(xyz))
    cells = as_cells(grid)
    tiles, marks = mark_tiles(cells, asked)
    try:
        image = build_image(xyz, scanner, cells, marks)
    except UnusableGrid as refusal:
        raise _no_grid(str(refusal)) from refusal
    found = np.full(len(xyz) if asked is None else len(asked), np.nan)
    _fill(xyz, scanner, cells, image, (beam_radius, half_divergence), asked, tiles, found, progress)
    return found[where]


def _no_grid(why: str) -> BadInput:
    return BadInput(
        f"The share of a beam on its surface needs the rows and columns of the scan: {why}.",
        "Open the scan in a format that keeps them, such as PTX or E57.",
    )


def _fill(
    xyz: Floats, scanner: Floats, cells: Cells, image: RangeImage, beam: tuple[float, float],
    asked: Ints | None, tiles: Ints, found: Floats, progress: Progress,
) -> None:  # fmt: skip
    from app.core.kernels import partial_hits as kernel
    from app.core.kernels.hit_pieces import Scene

    hidden, distance = _find_hidden(xyz, scanner, cells, image)
    several = _mark_several(cells, image, hidden, distance)
    beams = image.beams
    scene = Scene(
        image.inverse, several, beams.down, beams.turn, beams.level, beams.seam, beam[0],
        float(np.tan(beam[1])), beam_rays(), edge_places(), image.noise, GATES, LEAST_GATE,
    )  # fmt: skip
    slot = slots_of(asked, len(xyz))

    def work(first: int, last: int) -> None:
        kernel.share_tiles(scene, image.number, slot, tiles[first:last], TILE, found)

    run_in_pieces(work, np.arange(len(tiles) + 1), progress, "partial hits")
    wanted = slot[hidden] >= 0
    hidden, distance = hidden[wanted], distance[wanted]
    if len(hidden):  # tile by tile, so that each is loaded once
        row, column = cells.row[hidden], cells.column[hidden]
        order = np.lexsort((column // TILE, row // TILE))
        values = np.empty(len(hidden))
        kernel.share_hidden(scene, row[order], column[order], distance[order], TILE, values)
        found[slot[hidden[order]]] = values


def _find_hidden(
    xyz: Floats, scanner: Floats, cells: Cells, image: RangeImage
) -> tuple[Ints, Floats]:
    """Points with a range that are not the nearest of their cell, and their ranges."""
    if image.filled == len(xyz):
        return np.empty(0, np.int64), np.empty(0)
    number = image.number[cells.row, cells.column]
    hidden = np.flatnonzero((number > 0) & (number != np.arange(1, len(xyz) + 1)))
    distance = np.sqrt(((xyz[hidden] - scanner) ** 2).sum(axis=1))
    usable = np.isfinite(distance) & (distance > 0.0)
    return hidden[usable], distance[usable]


def _mark_several(cells: Cells, image: RangeImage, hidden: Ints, distance: Floats) -> Bools:
    """Cells with returns farther apart than noise explains."""
    row, column = cells.row[hidden], cells.column[hidden]
    apart = np.abs(distance - 1.0 / image.inverse[row, column])
    far = apart > max(LEAST_GATE, GATES * image.noise)
    several = np.zeros(image.number.shape, np.bool_)
    several[row[far], column[far]] = True
    return several


@cache
def beam_rays() -> Floats:
    """Offsets in radii and shares of rays that stand for equal areas of a Gaussian beam, (3, k).

    The beam ends at its 1/e² radius: energy exp(-2 s²) at s radii.
    """
    number = np.arange(RAYS)
    radius = np.sqrt((number + 0.5) / RAYS)
    energy = np.exp(-2.0 * radius**2)
    turn = GOLDEN * number
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), energy / energy.sum()])


@cache
def edge_places() -> Floats:
    """Where a straight edge leaves a share 0, …, 1 of the beam beyond it, radii; (PLACES,).

    1 for none of the beam, 0 for half of it, -1 for all.
    """
    from scipy.special import erf

    place = np.linspace(-1.0, 1.0, 2001)
    strip = np.exp(-2.0 * place**2) * erf(np.sqrt(2.0 * (1.0 - place**2)))
    below = np.append(0.0, np.cumsum(strip[1:] + strip[:-1]))
    places: Floats = -np.interp(np.linspace(0.0, 1.0, PLACES), below / below[-1], place)
    return places
